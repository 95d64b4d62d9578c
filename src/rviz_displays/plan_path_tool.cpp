#include "rviz_displays/plan_path_tool.h"

#include <algorithm>
#include <cmath>

#include <OgrePlane.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <pluginlib/class_list_macros.hpp>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/geometry.h>
#include <rviz/viewport_mouse_event.h>

#include "rviz_displays/map_display.h"
#include "scene/landmark_shapes.h"
#include "scene/ltr_scene.h"

namespace hymm {
namespace {

constexpr core::Pixel kPathColour = {255, 89, 191, 255};
constexpr std::size_t kDoorsInScene = 8;  // more would not be read
constexpr float kLetterHeight = 1.2F;

geometry_msgs::Point pointAt(const Eigen::Vector2d& place) {
  geometry_msgs::Point point;
  point.x = place.x();
  point.y = place.y();
  return point;
}

template <class Ids>
std::string listOf(const Ids& ids, std::size_t most) {
  std::string list;
  for (std::size_t i = 0; i < std::min(most, ids.size()); ++i) {
    list += (list.empty() ? "" : " > ") + std::to_string(ids[i]);
  }
  return ids.size() > most ? list + " > ..." : list;
}

}  // namespace

PlanPathTool::PlanPathTool() {
  shortcut_key_ = 'p';
  rviz::Property* container = getPropertyContainer();
  service_ = new rviz::StringProperty("Service", "plan_path", "Of door_planner.", container);
  frame_ = new rviz::StringProperty("Frame", "map", "Of the service's places.", container);
  from_vehicle_ = new rviz::BoolProperty(
      "From the vehicle", false, "One click asks for a path from where the vehicle is.", container);
  tolerance_ = new rviz::FloatProperty(
      "Tolerance", -1.0F,
      "By which an occupied start or goal may be moved, m; negative: as configured.", container);
  lowest_information_ = new rviz::FloatProperty(
      "Lowest information", 0.0F, "Stay inside the level set of this value, 1/m^2; 0: anywhere.",
      container);
  width_ = new rviz::FloatProperty("Line width", 0.5F, "m", container);
  width_->setMin(0.01F);
  const auto result = [container](const char* name, const char* description) {
    auto* property = new rviz::StringProperty(name, "", description, container);
    property->setReadOnly(true);
    property->setShouldBeSaved(false);
    return property;
  };
  status_ = result("Status", "What the planner answered.");
  cost_ = result("Cost", "Along the path; with the uncertainty of the map's shape.");
  length_ = result("Length", "m");
  shape_factor_ = result("Worst shape factor", "K of the triangles on the way.");
  doors_ = result("Doors", "In the order of the way.");
}

PlanPathTool::~PlanPathTool() {
  if (node_ == nullptr) return;
  line_.reset();
  text_node_->detachAllObjects();
  text_.reset();
  scene_manager_->destroySceneNode(text_node_);
  scene_manager_->destroySceneNode(node_);
}

void PlanPathTool::onInitialize() {
  setName("Plan path");
  node_ = scene_manager_->getRootSceneNode()->createChildSceneNode();
  text_node_ = node_->createChildSceneNode();
  line_ = std::make_unique<MeshObject>(node_, MeshObject::Kind::kTriangles, makeFlatMaterial(),
                                       kDrawPlans);
}

void PlanPathTool::activate() { tell("Click where the path starts; right click forgets it."); }

void PlanPathTool::deactivate() {}

void PlanPathTool::tell(const QString& sentence) {
  setStatus(sentence);
  status_->setString(sentence);
}

void PlanPathTool::update(float /*wall_dt*/, float /*ros_dt*/) {
  calls_.poll();
  placeScene();
}

bool PlanPathTool::placeScene() {
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  const bool known = context_->getFrameManager()->getTransform(frame_->getStdString(), ros::Time(),
                                                               position, orientation);
  node_->setVisible(known);
  if (!known) return false;
  node_->setPosition(position);
  node_->setOrientation(orientation);
  return true;
}

std::optional<Eigen::Vector2d> PlanPathTool::placeAt(const rviz::ViewportMouseEvent& event) {
  if (!placeScene()) {
    tell("The frame '" + frame_->getString() + "' cannot be placed in RViz's fixed frame.");
    return std::nullopt;
  }
  const Ogre::Vector3 up = node_->_getDerivedOrientation() * Ogre::Vector3::UNIT_Z;
  Ogre::Plane ground(up, node_->_getDerivedPosition());
  Ogre::Vector3 hit;
  if (!rviz::getPointOnPlaneFromWindowXY(event.viewport, ground, event.x, event.y, hit)) {
    tell("There is no ground under the mouse.");
    return std::nullopt;
  }
  const Ogre::Vector3 place = node_->convertWorldToLocalPosition(hit);
  return Eigen::Vector2d(static_cast<double>(place.x), static_cast<double>(place.y));
}

int PlanPathTool::processMouseEvent(rviz::ViewportMouseEvent& event) {
  if (event.rightDown()) {
    start_.reset();
    goal_.reset();
    path_.clear();
    ++asked_;
    draw();
    tell("Click where the path starts.");
    return Render;
  }
  if (!event.leftDown()) return 0;
  const std::optional<Eigen::Vector2d> place = placeAt(event);
  if (!place) return 0;
  const bool begins = !from_vehicle_->getBool() && (!start_ || goal_);
  path_.clear();
  if (begins) {
    start_ = place;
    goal_.reset();
    tell("Click where it ends.");
  } else {
    goal_ = place;
    ask(*place);
  }
  draw();
  return Render;
}

void PlanPathTool::ask(const Eigen::Vector2d& goal) {
  PlanPath::Request request;
  request.from_pose = from_vehicle_->getBool();
  if (start_) request.start = pointAt(*start_);
  request.goal = pointAt(goal);
  request.tolerance = static_cast<double>(tolerance_->getFloat());
  request.lowest_information = static_cast<double>(lowest_information_->getFloat());
  tell("Planning.");
  calls_.call<PlanPath>(handle_.resolveName(service_->getStdString()), request,
                        [this, number = ++asked_](bool reached, const PlanPath::Response& answer) {
                          if (number == asked_) take(reached, answer);
                        });
}

void PlanPathTool::take(bool reached, const PlanPath::Response& response) {
  path_.clear();
  const bool found = reached && response.success;
  cost_->setString(found ? QString("%1 (%2 with uncertainty)")
                               .arg(response.cost, 0, 'f', 1)
                               .arg(response.cost_with_uncertainty, 0, 'f', 1)
                         : "");
  length_->setString(found ? QString::number(response.length, 'f', 1) : "");
  shape_factor_->setString(found ? QString::number(response.worst_shape_factor, 'f', 3) : "");
  doors_->setString(found ? QString::fromStdString(listOf(response.doors, response.doors.size()))
                          : "");
  if (!reached) {
    tell("Nobody answers " + service_->getString() + ". Is door_planner running?");
  } else {
    for (const geometry_msgs::PoseStamped& pose : response.path.poses) {
      const Eigen::Vector2d place(pose.pose.position.x, pose.pose.position.y);
      if (place.allFinite()) path_.push_back(place);
    }
    tell(QString::fromStdString(response.message));
  }
  std::string caption = reached ? response.status : "no answer";
  if (found) {
    caption = "cost " + QString::number(response.cost, 'f', 1).toStdString() + ", " +
              QString::number(response.length, 'f', 1).toStdString() + " m\n" +
              std::to_string(response.doors.size()) +
              " doors: " + listOf(response.doors, kDoorsInScene);
  }
  draw();
  write(caption);
  context_->queueRender();
}

// A new text each time: one whose first caption is empty is never drawn.
void PlanPathTool::write(const std::string& caption) {
  text_node_->detachAllObjects();
  text_ = std::make_unique<rviz::MovableText>(caption);
  text_->setCharacterHeight(kLetterHeight);
  text_->setTextAlignment(rviz::MovableText::H_LEFT, rviz::MovableText::V_ABOVE);
  text_->setRenderQueueGroup(kDrawPlans);
  text_node_->attachObject(text_.get());
}

void PlanPathTool::draw() {
  core::FlatVertices triangles;
  const auto width_m = static_cast<double>(width_->getFloat());
  for (std::size_t i = 0; i + 1 < path_.size(); ++i) {
    for (const Eigen::Vector2d& corner : core::wideLine(path_[i], path_[i + 1], width_m)) {
      triangles.add(corner, kPathColour);
    }
  }
  for (const std::optional<Eigen::Vector2d>& place : {start_, goal_}) {
    if (!place) continue;
    const auto border = core::ellipseBorder(*place, Eigen::Matrix2d::Identity(), 1.5 * width_m, 12);
    for (std::size_t i = 1; i + 1 < border.size(); ++i) {
      triangles.add(border[0], kPathColour);
      triangles.add(border[i], kPathColour);
      triangles.add(border[i + 1], kPathColour);
    }
  }
  line_->show(triangles, kPlanHeight_m);
  if (path_.empty()) text_node_->detachAllObjects();
  if (goal_) {
    text_node_->setPosition(static_cast<float>(goal_->x() + 2.0 * width_m),
                            static_cast<float>(goal_->y() + 2.0 * width_m), kPlanHeight_m);
  }
}

}  // namespace hymm

PLUGINLIB_EXPORT_CLASS(hymm::PlanPathTool, rviz::Tool)
