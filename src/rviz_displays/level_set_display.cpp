#include "rviz_displays/level_set_display.h"

#include <cmath>

#include <OgreSceneNode.h>
#include <pluginlib/class_list_macros.hpp>
#include <rviz/display_context.h>

namespace hymm {
namespace {

const char* const kAll = "all";
constexpr std::uint32_t kQueue = 100;

QString nameOf(double value) { return QString::number(value, 'g', 6); }

}  // namespace

LevelSetDisplay::LevelSetDisplay() {
  topic_ = new rviz::RosTopicProperty(
      "Topic", "level_sets", ros::message_traits::datatype<LevelSet>(),
      "Level sets (hymm/LevelSet), one message for each value.", this, SLOT(updateTopic()));
  value_ = new rviz::EditableEnumProperty(
      "Value", kAll, "Show all sets over one another, or only that of this value (1/m^2).", this,
      SLOT(updateStyle()));
  connect(value_, SIGNAL(requestOptions(EditableEnumProperty*)), this, SLOT(listValues()));
  alpha_ =
      new rviz::FloatProperty("Opacity", 0.25F, "Of each set, 0 to 1.", this, SLOT(updateStyle()));
  alpha_->setMin(0.0F);
  alpha_->setMax(1.0F);
}

LevelSetDisplay::~LevelSetDisplay() { subscriber_.shutdown(); }

void LevelSetDisplay::onInitialize() { MapDisplay::onInitialize(); }

void LevelSetDisplay::setTopic(const QString& topic, const QString& /*datatype*/) {
  topic_->setString(topic);
}

void LevelSetDisplay::onEnable() { updateTopic(); }

void LevelSetDisplay::onDisable() {
  subscriber_.shutdown();
  clear();
}

void LevelSetDisplay::reset() {
  MapDisplay::reset();
  updateTopic();
}

void LevelSetDisplay::updateTopic() {
  if (!isEnabled()) return;
  subscriber_.shutdown();
  clear();
  if (topic_->getTopicStd().empty()) return;
  subscriber_ = update_nh_.subscribe(topic_->getTopicStd(), kQueue, &LevelSetDisplay::take, this);
}

void LevelSetDisplay::updateStyle() { changed_ = true; }

void LevelSetDisplay::listValues() {
  value_->clearOptions();
  value_->addOption(kAll);
  for (const auto& [value, set] : sets_) value_->addOption(nameOf(value));
}

void LevelSetDisplay::clear() {
  sets_.clear();
  frame_.clear();
  refused_ = 0;
  changed_ = true;
}

void LevelSetDisplay::take(const LevelSet& message) {
  std::vector<core::ShownLeaf> leaves;
  leaves.reserve(message.leaves.size());
  for (const LevelSetLeaf& leaf : message.leaves) {
    leaves.push_back({static_cast<double>(leaf.x), static_cast<double>(leaf.y),
                      static_cast<double>(leaf.edge), leaf.island});
  }
  changed_ = true;
  std::optional<std::string> problem = core::problemWith(leaves);
  if (!std::isfinite(message.value)) problem = "the value of the set is not finite";
  if (problem) {
    ++refused_;
    refusal_ = *problem;
    return;
  }
  Set& set = sets_[message.value];
  set.leaves = std::move(leaves);
  set.islands = message.islands.size();
  set.area_m2 = message.area;
  set.map_version = message.map_version;
  set.complete = message.complete;
  frame_ = message.header.frame_id.empty() ? "map" : message.header.frame_id;
}

bool LevelSetDisplay::isShown(double value) const {
  const QString chosen = value_->getString().trimmed();
  return chosen.isEmpty() || chosen == kAll || chosen == nameOf(value);
}

void LevelSetDisplay::update(float /*wall_dt*/, float /*ros_dt*/) {
  if (changed_) draw();
  changed_ = false;
  followFrame(frame_);
}

void LevelSetDisplay::draw() {
  int rank = 0;
  for (auto& [value, set] : sets_) {
    if (!set.mesh) {
      set.mesh = std::make_unique<MeshObject>(scene_node_, MeshObject::Kind::kTriangles,
                                              makeFlatMaterial(), kDrawLevelSets);
    }
    const bool shown = isShown(value);
    set.mesh->show(
        core::levelSetTriangles(shown ? set.leaves : std::vector<core::ShownLeaf>(), rank,
                                static_cast<int>(sets_.size()), alpha_->getFloat()),
        kLevelSetHeight_m + 0.001F * static_cast<float>(rank));
    ++rank;
  }
  tell();
  context_->queueRender();
}

void LevelSetDisplay::tell() {
  if (refused_ > 0) {
    setStatusStd(Level::Error, "Messages",
                 std::to_string(refused_) + " refused, the last because " + refusal_);
  } else {
    deleteStatus("Messages");
  }
  std::string shown;
  for (const auto& [value, set] : sets_) {
    if (!isShown(value)) continue;
    if (!shown.empty()) shown += "; ";
    shown += nameOf(value).toStdString() + "/m²: " + std::to_string(set.leaves.size()) +
             " leaves, " + std::to_string(set.islands) + " islands, " +
             std::to_string(std::lround(set.area_m2)) + " m², version " +
             std::to_string(set.map_version) + (set.complete ? "" : ", not complete yet");
  }
  if (!shown.empty()) {
    setStatusStd(Level::Ok, "Sets", shown);
  } else if (sets_.empty()) {
    setStatusStd(Level::Warn, "Sets",
                 "None has come on '" + topic_->getTopicStd() + "'. Is information_map running?");
  } else {
    listValues();
    setStatusStd(Level::Warn, "Sets",
                 "There is none of the value '" + value_->getStdString() + "': choose another.");
  }
}

}  // namespace hymm

PLUGINLIB_EXPORT_CLASS(hymm::LevelSetDisplay, rviz::Display)
