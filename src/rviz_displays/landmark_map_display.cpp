#include "rviz_displays/landmark_map_display.h"

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <pluginlib/class_list_macros.hpp>
#include <rviz/display_context.h>

#include "scene/landmark_shapes.h"

namespace hymm {

LandmarkMapDisplay::LandmarkMapDisplay() {
  map_topic_ =
      new rviz::RosTopicProperty("Topic", "landmarks", ros::message_traits::datatype<LandmarkMap>(),
                                 "Whole maps (hymm/LandmarkMap).", this, SLOT(updateTopics()));
  update_topic_ = new rviz::RosTopicProperty(
      "Updates topic", "landmark_updates", ros::message_traits::datatype<LandmarkUpdate>(),
      "Changes in between (hymm/LandmarkUpdate).", this, SLOT(updateTopics()));
  sigmas_ = new rviz::FloatProperty("Sigmas", 2.0F, "Standard deviations that an ellipse spans.",
                                    this, SLOT(updateStyle()));
  sigmas_->setMin(0.1F);
  magnification_ = new rviz::FloatProperty(
      "Magnification", 1.0F,
      "Of the ellipses only: those of landmarks that were often seen are centimetres wide.", this,
      SLOT(updateStyle()));
  magnification_->setMin(0.1F);
  ellipse_alpha_ = new rviz::FloatProperty("Opacity", 0.3F, "Of the ellipses, 0 to 1.", this,
                                           SLOT(updateStyle()));
  ellipse_alpha_->setMin(0.0F);
  ellipse_alpha_->setMax(1.0F);
  smallest_disc_ = new rviz::FloatProperty(
      "Smallest disc", 0.6F,
      "Diameter (m) with which a landmark is drawn at least, that a pole stays visible.", this,
      SLOT(updateStyle()));
  smallest_disc_->setMin(0.0F);
  ids_ = new rviz::BoolProperty("Ids", true, "Show the id of each landmark.", this,
                                SLOT(updateStyle()));
  id_height_ = new rviz::FloatProperty("Height", 1.0F, "Of the letters, m.", ids_,
                                       SLOT(updateStyle()), this);
  id_height_->setMin(0.01F);
  most_ids_ = new rviz::IntProperty(
      "At most", 500, "With more landmarks than these none has its id shown: it would take long.",
      ids_, SLOT(updateStyle()), this);
  most_ids_->setMin(0);
}

LandmarkMapDisplay::~LandmarkMapDisplay() {
  feed_.stop();
  if (initialized()) clearIds();
}

void LandmarkMapDisplay::onInitialize() {
  MapDisplay::onInitialize();
  const Ogre::MaterialPtr material = makeFlatMaterial();
  using Kind = MeshObject::Kind;
  ellipses_ = std::make_unique<MeshObject>(scene_node_, Kind::kTriangles, material, kDrawEllipses);
  lines_ = std::make_unique<MeshObject>(scene_node_, Kind::kLines, material, kDrawEllipses);
  discs_ = std::make_unique<MeshObject>(scene_node_, Kind::kTriangles, material, kDrawDiscs);
}

void LandmarkMapDisplay::setTopic(const QString& topic, const QString& /*datatype*/) {
  map_topic_->setString(topic);
}

void LandmarkMapDisplay::onEnable() { updateTopics(); }

void LandmarkMapDisplay::onDisable() { feed_.stop(); }

void LandmarkMapDisplay::updateTopics() {
  if (!isEnabled()) return;
  feed_.subscribe(update_nh_, map_topic_->getTopicStd(), update_topic_->getTopicStd());
}

void LandmarkMapDisplay::updateStyle() { style_changed_ = true; }

void LandmarkMapDisplay::reset() {
  MapDisplay::reset();
  updateTopics();
}

void LandmarkMapDisplay::update(float /*wall_dt*/, float /*ros_dt*/) {
  if (feed_.takeNews() || style_changed_) draw();
  style_changed_ = false;
  followFrame(feed_.frame());
}

void LandmarkMapDisplay::draw() {
  const LandmarkFeed::State state = feed_.state();
  setStatusStd(state.ok ? Level::Ok : Level::Warn, "Landmarks", state.sentence);
  core::LandmarkStyle style;
  style.sigmas = static_cast<double>(sigmas_->getFloat());
  style.magnification = static_cast<double>(magnification_->getFloat());
  style.smallest_disc_m = static_cast<double>(smallest_disc_->getFloat());
  style.ellipse_alpha = ellipse_alpha_->getFloat();
  const auto& landmarks = feed_.map().landmarks;
  ellipses_->show(core::filledEllipses(landmarks, style), kEllipseHeight_m);
  lines_->show(core::ellipseLines(landmarks, style), kEllipseHeight_m);
  discs_->show(core::landmarkDiscs(landmarks, style), kDiscHeight_m);
  drawIds();
  context_->queueRender();
}

void LandmarkMapDisplay::drawIds() {
  const auto& landmarks = feed_.map().landmarks;
  const bool too_many = landmarks.size() > static_cast<std::size_t>(most_ids_->getInt());
  if (!ids_->getBool() || too_many) {
    clearIds();
    setStatusStd(Level::Ok, "Ids",
                 too_many && ids_->getBool() ? "Not shown: more landmarks than 'At most'"
                                             : std::to_string(labels_.size()) + " shown");
    return;
  }
  while (labels_.size() > landmarks.size()) {
    scene_manager_->destroySceneNode(labels_.back().node);
    labels_.pop_back();
  }
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const std::string caption = std::to_string(landmarks[i].id);
    if (i == labels_.size()) {
      labels_.push_back(
          {scene_node_->createChildSceneNode(), std::make_unique<rviz::MovableText>(caption)});
      labels_[i].text->setTextAlignment(rviz::MovableText::H_LEFT, rviz::MovableText::V_ABOVE);
      labels_[i].text->setRenderQueueGroup(kDrawDiscs);
      labels_[i].node->attachObject(labels_[i].text.get());
    }
    const auto offset =
        static_cast<float>(0.3 + 0.5 * static_cast<double>(smallest_disc_->getFloat()));
    const Eigen::Vector2f place = landmarks[i].position.cast<float>();
    labels_[i].text->setCaption(caption);
    labels_[i].text->setCharacterHeight(id_height_->getFloat());
    labels_[i].node->setPosition(place.x() + offset, place.y(), kPlanHeight_m);
  }
  setStatusStd(Level::Ok, "Ids", std::to_string(labels_.size()) + " shown");
}

void LandmarkMapDisplay::clearIds() {
  for (Label& label : labels_) {
    label.node->detachAllObjects();
    scene_manager_->destroySceneNode(label.node);
  }
  labels_.clear();
}

}  // namespace hymm

PLUGINLIB_EXPORT_CLASS(hymm::LandmarkMapDisplay, rviz::Display)
