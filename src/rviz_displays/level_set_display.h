#pragma once

#include <map>
#include <memory>
#include <vector>

#include <hymm/LevelSet.h>
#include <rviz/properties/editable_enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>

#include "rviz_displays/map_display.h"
#include "rviz_displays/mesh_object.h"
#include "scene/level_set_mesh.h"

namespace hymm {

/// The level sets of the information map: squares filled by island (hue) and value (brightness).
class LevelSetDisplay : public MapDisplay {
  Q_OBJECT

 public:
  LevelSetDisplay();
  ~LevelSetDisplay() override;

  void setTopic(const QString& topic, const QString& datatype) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void updateTopic();
  void updateStyle();
  void listValues();

 private:
  struct Set {
    std::vector<core::ShownLeaf> leaves;
    std::size_t islands = 0;
    double area_m2 = 0.0;
    std::uint64_t map_version = 0;
    bool complete = true;
    std::unique_ptr<MeshObject> mesh;
  };

  void take(const LevelSet& message);
  void clear();
  void draw();
  void tell();
  bool isShown(double value) const;

  rviz::RosTopicProperty* topic_;
  rviz::EditableEnumProperty* value_;
  rviz::FloatProperty* alpha_;

  ros::Subscriber subscriber_;
  std::string frame_;
  std::map<double, Set> sets_;  ///< by value
  std::size_t refused_ = 0;
  std::string refusal_;
  bool changed_ = true;
};

}  // namespace hymm
