#pragma once

#include <memory>
#include <vector>

#include <rviz/ogre_helpers/movable_text.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/ros_topic_property.h>

#include "rviz_displays/landmark_feed.h"
#include "rviz_displays/map_display.h"
#include "rviz_displays/mesh_object.h"

namespace hymm {

/// The landmarks: discs coloured by type, ellipses of their covariances, ids.
class LandmarkMapDisplay : public MapDisplay {
  Q_OBJECT

 public:
  LandmarkMapDisplay();
  ~LandmarkMapDisplay() override;

  void setTopic(const QString& topic, const QString& datatype) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void updateTopics();
  void updateStyle();

 private:
  struct Label {
    Ogre::SceneNode* node;
    std::unique_ptr<rviz::MovableText> text;
  };

  void draw();
  void drawIds();
  void clearIds();

  rviz::RosTopicProperty* map_topic_;
  rviz::RosTopicProperty* update_topic_;
  rviz::FloatProperty* sigmas_;
  rviz::FloatProperty* magnification_;
  rviz::FloatProperty* ellipse_alpha_;
  rviz::FloatProperty* smallest_disc_;
  rviz::BoolProperty* ids_;
  rviz::FloatProperty* id_height_;
  rviz::IntProperty* most_ids_;

  LandmarkFeed feed_;
  bool style_changed_ = false;
  std::unique_ptr<MeshObject> ellipses_, lines_, discs_;
  std::vector<Label> labels_;
};

}  // namespace hymm
