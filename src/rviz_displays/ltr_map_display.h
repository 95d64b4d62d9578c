#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <hymm/LtrGrid.h>
#include <hymm/LtrMap.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/editable_enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <visualization_msgs/MarkerArray.h>

#include "hybrid_map/ltr_topology.h"
#include "rviz_displays/landmark_feed.h"
#include "rviz_displays/layer_textures.h"
#include "rviz_displays/map_display.h"
#include "rviz_displays/mesh_object.h"

namespace hymm {

/// The local triangular regions: sides as lines, a layer as a texture on each triangle, doors. The
/// landmark map gives the vertices: after a correction only these are written anew.
class LtrMapDisplay : public MapDisplay {
  Q_OBJECT

 public:
  LtrMapDisplay();
  ~LtrMapDisplay() override;

  void setTopic(const QString& topic, const QString& datatype) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void updateTopics();
  void updateLayer();
  void updateStyle();
  void listLayers();

 private:
  /// LTRs whose textures are on one page.
  struct PageMesh {
    std::unique_ptr<MeshObject> mesh;
    std::vector<std::size_t> ltrs;  ///< their numbers in `ltrs_`
  };

  void takeLtrs(const LtrMap& message);
  void takeGrid(const LtrGrid& message);
  void takeDoors(const visualization_msgs::MarkerArray& message);
  void clear();
  void refuse(const std::string& problem);

  /// Which LTRs are drawn with which page, and where on it: changes with the LTRs only.
  void layOutPages();
  /// The vertices, from the landmarks: changes with each correction.
  void moveVertices();
  void drawLines();
  void drawDoors();
  void tell();
  void tellTriangles();
  void tellLayer();
  void tellDoors();
  void tellRate(float wall_dt);

  rviz::RosTopicProperty *ltr_topic_, *grid_topic_, *map_topic_, *update_topic_, *door_topic_;
  rviz::EditableEnumProperty* layer_;
  rviz::BoolProperty* automatic_range_;
  rviz::FloatProperty *lowest_, *highest_;
  rviz::FloatProperty* alpha_;
  rviz::BoolProperty* lines_shown_;
  rviz::ColorProperty* line_colour_;
  rviz::FloatProperty* line_alpha_;
  rviz::BoolProperty* doors_shown_;
  rviz::ColorProperty* door_colour_;
  rviz::FloatProperty* door_width_;

  std::vector<ros::Subscriber> subscribers_;
  LandmarkFeed feed_;
  LayerTextures textures_;
  std::vector<core::LtrTopology> ltrs_;  ///< by ascending id
  std::vector<std::pair<int, int>> sides_;
  std::uint64_t landmark_version_ = 0;  ///< that the LTRs belong to
  bool has_ltrs_ = false;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> doors_;
  std::string door_frame_;

  std::vector<PageMesh> pages_;
  std::unique_ptr<MeshObject> lines_, door_lines_;
  std::uint64_t laid_out_ = 0;  ///< revision of the textures that the pages are of
  bool ltrs_changed_ = true, style_changed_ = true, doors_changed_ = true;
  std::size_t incomplete_ = 0;  ///< LTRs with a vertex that is not in the landmark map
  std::size_t refused_ = 0;
  std::string refusal_;
  float rate_window_s_ = 0.0F;
  int frames_ = 0;
};

}  // namespace hymm
