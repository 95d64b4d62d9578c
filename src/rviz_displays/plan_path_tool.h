#pragma once

#include <memory>
#include <optional>

#include <hymm/PlanPath.h>
#include <rviz/ogre_helpers/movable_text.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/string_property.h>
#include <rviz/tool.h>

#include "rviz_displays/mesh_object.h"
#include "rviz_displays/service_calls.h"

namespace hymm {

/// Two clicks, start and goal, ask door_planner for a path (plan_path) and show it with its cost
/// and the doors on the way. The vehicle's plan is left alone.
class PlanPathTool : public rviz::Tool {
  Q_OBJECT

 public:
  PlanPathTool();
  ~PlanPathTool() override;

  void onInitialize() override;
  void activate() override;
  void deactivate() override;
  void update(float wall_dt, float ros_dt) override;
  int processMouseEvent(rviz::ViewportMouseEvent& event) override;

 private:
  /// The map's frame in RViz's fixed one; nothing, with a status, where it is not known.
  bool placeScene();
  std::optional<Eigen::Vector2d> placeAt(const rviz::ViewportMouseEvent& event);
  void ask(const Eigen::Vector2d& goal);
  void take(bool reached, const PlanPath::Response& response);
  void draw();
  void write(const std::string& caption);
  void tell(const QString& sentence);

  rviz::StringProperty *service_, *frame_;
  rviz::BoolProperty* from_vehicle_;
  rviz::FloatProperty *tolerance_, *lowest_information_, *width_;
  rviz::StringProperty *status_, *cost_, *length_, *shape_factor_, *doors_;

  ros::NodeHandle handle_;
  ServiceCalls calls_;
  Ogre::SceneNode *node_ = nullptr, *text_node_ = nullptr;
  std::unique_ptr<MeshObject> line_;
  std::unique_ptr<rviz::MovableText> text_;
  std::optional<Eigen::Vector2d> start_, goal_;
  std::vector<Eigen::Vector2d> path_;
  std::size_t asked_ = 0;  ///< an answer to an earlier question is not shown
};

}  // namespace hymm
