#include "rviz_displays/ltr_map_display.h"

#include <cmath>
#include <set>

#include <OgreSceneNode.h>
#include <pluginlib/class_list_macros.hpp>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>

#include "ros/grid_conversions.h"
#include "scene/ltr_scene.h"

namespace hymm {
namespace {

const char* const kNoLayer = "none";
constexpr std::uint32_t kMaps = 2, kGrids = 20000;
// A frame may take so long for new textures: the view stays smooth while thousands come.
constexpr double kLongestPainting_s = 0.02;
constexpr float kRateWindow_s = 5.0F;

core::Pixel pixelOf(const rviz::ColorProperty& property, float alpha) {
  const QColor colour = property.getColor();
  return core::pixelOf({static_cast<float>(colour.redF()), static_cast<float>(colour.greenF()),
                        static_cast<float>(colour.blueF()), alpha});
}

}  // namespace

LtrMapDisplay::LtrMapDisplay() {
  using ros::message_traits::datatype;
  const auto topic = [this](const char* name, const char* value, const char* type,
                            const char* description) {
    return new rviz::RosTopicProperty(name, value, type, description, this, SLOT(updateTopics()));
  };
  ltr_topic_ = topic("Topic", "ltrs", datatype<LtrMap>(), "Triangles (hymm/LtrMap).");
  grid_topic_ = topic("Layers topic", "ltr_grids", datatype<LtrGrid>(), "Layers (hymm/LtrGrid).");
  map_topic_ = topic("Landmarks topic", "landmarks", datatype<LandmarkMap>(),
                     "Whole landmark maps (hymm/LandmarkMap): where the vertices are.");
  update_topic_ = topic("Updates topic", "landmark_updates", datatype<LandmarkUpdate>(),
                        "Changes of landmarks in between (hymm/LandmarkUpdate).");
  door_topic_ = topic("Doors topic", "doors", datatype<visualization_msgs::MarkerArray>(),
                      "Doors of door_planner: lines of the namespace 'doors'.");
  layer_ = new rviz::EditableEnumProperty("Layer", "occupancy",
                                          "Shown on the triangles; 'none' shows their sides only.",
                                          this, SLOT(updateLayer()));
  connect(layer_, SIGNAL(requestOptions(EditableEnumProperty*)), this, SLOT(listLayers()));
  automatic_range_ =
      new rviz::BoolProperty("Range of values as they come", true,
                             "Colours of a layer of values span those that came; else those below.",
                             this, SLOT(updateLayer()));
  lowest_ = new rviz::FloatProperty("Lowest", 0.0F, "Shown in deep blue.", automatic_range_,
                                    SLOT(updateLayer()), this);
  highest_ = new rviz::FloatProperty("Highest", 1.0F, "Shown in yellow.", automatic_range_,
                                     SLOT(updateLayer()), this);
  automatic_range_->setDisableChildrenIfFalse(false);
  alpha_ =
      new rviz::FloatProperty("Opacity", 1.0F, "Of the layer, 0 to 1.", this, SLOT(updateStyle()));
  alpha_->setMin(0.0F);
  alpha_->setMax(1.0F);
  lines_shown_ = new rviz::BoolProperty("Sides", true, "Draw the sides of the triangles.", this,
                                        SLOT(updateStyle()));
  line_colour_ = new rviz::ColorProperty("Colour", QColor(120, 160, 200), "Of the sides.",
                                         lines_shown_, SLOT(updateStyle()), this);
  line_alpha_ = new rviz::FloatProperty("Opacity", 0.7F, "Of the sides, 0 to 1.", lines_shown_,
                                        SLOT(updateStyle()), this);
  doors_shown_ = new rviz::BoolProperty("Doors", true, "Draw the doors between triangles.", this,
                                        SLOT(updateStyle()));
  door_colour_ = new rviz::ColorProperty("Colour", QColor(90, 230, 210), "Of the doors.",
                                         doors_shown_, SLOT(updateStyle()), this);
  door_width_ = new rviz::FloatProperty("Width", 0.25F, "Of the doors' lines, m.", doors_shown_,
                                        SLOT(updateStyle()), this);
  door_width_->setMin(0.01F);
}

LtrMapDisplay::~LtrMapDisplay() {
  subscribers_.clear();
  feed_.stop();
  pages_.clear();
}

void LtrMapDisplay::onInitialize() {
  MapDisplay::onInitialize();
  lines_ = std::make_unique<MeshObject>(scene_node_, MeshObject::Kind::kLines, makeFlatMaterial(),
                                        kDrawLines);
  door_lines_ = std::make_unique<MeshObject>(scene_node_, MeshObject::Kind::kTriangles,
                                             makeFlatMaterial(), kDrawLines);
  updateLayer();
}

void LtrMapDisplay::setTopic(const QString& topic, const QString& /*datatype*/) {
  ltr_topic_->setString(topic);
}

void LtrMapDisplay::onEnable() { updateTopics(); }

void LtrMapDisplay::onDisable() {
  subscribers_.clear();
  feed_.stop();
  clear();
}

void LtrMapDisplay::reset() {
  MapDisplay::reset();
  updateTopics();
}

void LtrMapDisplay::updateTopics() {
  if (!isEnabled()) return;
  subscribers_.clear();
  clear();
  feed_.subscribe(update_nh_, map_topic_->getTopicStd(), update_topic_->getTopicStd());
  const auto subscribe = [this](const rviz::RosTopicProperty& topic, std::uint32_t queue,
                                auto callback) {
    if (topic.getTopicStd().empty()) return;
    subscribers_.push_back(update_nh_.subscribe(topic.getTopicStd(), queue, callback, this));
  };
  subscribe(*ltr_topic_, kMaps, &LtrMapDisplay::takeLtrs);
  subscribe(*grid_topic_, kGrids, &LtrMapDisplay::takeGrid);
  subscribe(*door_topic_, kMaps, &LtrMapDisplay::takeDoors);
}

void LtrMapDisplay::clear() {
  pages_.clear();
  textures_.clear();
  ltrs_.clear();
  sides_.clear();
  doors_.clear();
  door_frame_.clear();
  has_ltrs_ = false;
  incomplete_ = refused_ = 0;
  ltrs_changed_ = doors_changed_ = true;
}

void LtrMapDisplay::updateLayer() {
  const QString name = layer_->getString().trimmed();
  textures_.choose(name == kNoLayer ? "" : name.toStdString());
  const bool automatic = automatic_range_->getBool();
  lowest_->setHidden(automatic);
  highest_->setHidden(automatic);
  std::optional<core::ValueRange> range;
  if (!automatic) {
    range = core::ValueRange{static_cast<double>(lowest_->getFloat()),
                             static_cast<double>(highest_->getFloat())};
  }
  textures_.setRange(range);
  style_changed_ = true;
}

void LtrMapDisplay::updateStyle() { style_changed_ = doors_changed_ = true; }

void LtrMapDisplay::listLayers() {
  layer_->clearOptions();
  layer_->addOption(kNoLayer);
  for (const std::string& name : textures_.layers()) layer_->addOptionStd(name);
}

void LtrMapDisplay::refuse(const std::string& problem) {
  ++refused_;
  refusal_ = problem;
  style_changed_ = true;
}

void LtrMapDisplay::takeLtrs(const LtrMap& message) {
  std::set<int> retired;
  for (const core::LtrTopology& ltr : ltrs_) retired.insert(ltr.id);
  ltrs_ = fromMessage(message);
  for (const core::LtrTopology& ltr : ltrs_) retired.erase(ltr.id);
  // Layers of LTRs that are still to be told may have come first: they stay.
  for (const int ltr : retired) textures_.remove(ltr);
  landmark_version_ = message.landmark_version;
  has_ltrs_ = true;
  sides_ = core::sidesOf(ltrs_);
  ltrs_changed_ = true;
}

void LtrMapDisplay::takeGrid(const LtrGrid& message) {
  const core::ToldLayer told = {message.layer, message.model, message.alpha_cells,
                                message.beta_cells, message.channels};
  std::string problem;
  std::optional<core::LayerField> field = core::readLayer(told, message.cells, problem);
  if (!field) {
    refuse("LTR " + std::to_string(message.ltr) + ": " + problem);
    return;
  }
  textures_.take(message.ltr, message.layer, std::move(*field));
}

void LtrMapDisplay::takeDoors(const visualization_msgs::MarkerArray& message) {
  for (const visualization_msgs::Marker& marker : message.markers) {
    if (marker.ns != "doors") continue;
    doors_.clear();
    door_frame_ = marker.header.frame_id;
    const auto at = [](const geometry_msgs::Point& p) { return Eigen::Vector2d(p.x, p.y); };
    for (std::size_t i = 0; i + 1 < marker.points.size(); i += 2) {
      const Eigen::Vector2d from = at(marker.points[i]), to = at(marker.points[i + 1]);
      if (from.allFinite() && to.allFinite()) doors_.emplace_back(from, to);
    }
    doors_changed_ = true;
  }
}

void LtrMapDisplay::update(float wall_dt, float /*ros_dt*/) {
  const bool painted = textures_.paintSome(kLongestPainting_s);
  const bool moved = feed_.takeNews();
  const bool laid_out_anew = ltrs_changed_ || laid_out_ != textures_.revision();
  if (laid_out_anew) layOutPages();
  if (style_changed_) textures_.setAlpha(alpha_->getFloat());
  if (moved || laid_out_anew) moveVertices();
  if (moved || ltrs_changed_ || style_changed_) drawLines();
  if (doors_changed_) drawDoors();
  if (moved || laid_out_anew || style_changed_ || doors_changed_) tell();
  if (moved || laid_out_anew || painted || style_changed_ || doors_changed_) {
    context_->queueRender();
  }
  ltrs_changed_ = style_changed_ = doors_changed_ = false;
  followFrame(feed_.frame());
  tellRate(wall_dt);
}

void LtrMapDisplay::layOutPages() {
  laid_out_ = textures_.revision();
  for (PageMesh& page : pages_) page.ltrs.clear();
  pages_.resize(std::size_t(textures_.pages()));
  for (std::size_t number = 0; number < ltrs_.size(); ++number) {
    const core::AtlasPlace* place = textures_.find(ltrs_[number].id);
    if (place != nullptr) pages_[std::size_t(place->page)].ltrs.push_back(number);
  }
  for (std::size_t i = 0; i < pages_.size(); ++i) {
    PageMesh& page = pages_[i];
    if (!page.mesh) {
      page.mesh =
          std::make_unique<MeshObject>(scene_node_, MeshObject::Kind::kTriangles,
                                       textures_.material(static_cast<int>(i)), kDrawLayers);
    }
    std::vector<Eigen::Vector2f> coordinates;
    coordinates.reserve(3 * page.ltrs.size());
    for (const std::size_t number : page.ltrs) {
      const auto corners =
          core::textureCorners(*textures_.find(ltrs_[number].id), LayerTextures::kPageSize);
      coordinates.insert(coordinates.end(), corners.begin(), corners.end());
    }
    page.mesh->setTextureCoordinates(coordinates);
  }
}

void LtrMapDisplay::moveVertices() {
  incomplete_ = 0;
  std::vector<std::optional<core::Corners>> corners;
  corners.reserve(ltrs_.size());
  for (const core::LtrTopology& ltr : ltrs_) {
    corners.push_back(core::findCorners(feed_.map(), ltr));
    if (!corners.back()) ++incomplete_;
  }
  for (PageMesh& page : pages_) {
    std::vector<Eigen::Vector2f> positions;
    positions.reserve(3 * page.ltrs.size());
    for (const std::size_t number : page.ltrs) {
      // Without its landmarks a triangle shrinks to nothing: its place in the buffer stays.
      for (std::size_t k = 0; k < 3; ++k) {
        positions.push_back(corners[number] ? Eigen::Vector2f((*corners[number])[k].cast<float>())
                                            : Eigen::Vector2f::Zero());
      }
    }
    page.mesh->setPositions(positions, kLayerHeight_m);
  }
}

void LtrMapDisplay::drawLines() {
  core::FlatVertices lines;
  if (lines_shown_->getBool()) {
    const core::Pixel colour = pixelOf(*line_colour_, line_alpha_->getFloat());
    lines.positions.reserve(2 * sides_.size());
    lines.colours.reserve(2 * sides_.size());
    for (const auto& [first, second] : sides_) {
      const auto from = core::findPosition(feed_.map(), first);
      const auto to = core::findPosition(feed_.map(), second);
      if (!from || !to) continue;
      lines.add(*from, colour);
      lines.add(*to, colour);
    }
  }
  lines_->show(lines, kLineHeight_m);
}

void LtrMapDisplay::drawDoors() {
  core::FlatVertices triangles;
  if (doors_shown_->getBool()) {
    const core::Pixel colour = pixelOf(*door_colour_, 1.0F);
    for (const auto& [from, to] : doors_) {
      for (const Eigen::Vector2d& corner :
           core::wideLine(from, to, static_cast<double>(door_width_->getFloat()))) {
        triangles.add(corner, colour);
      }
    }
  }
  door_lines_->show(triangles, kLineHeight_m);
}

void LtrMapDisplay::tell() {
  const LandmarkFeed::State landmarks = feed_.state();
  setStatusStd(landmarks.ok ? Level::Ok : Level::Warn, "Landmarks", landmarks.sentence);
  tellTriangles();
  if (refused_ > 0) {
    setStatusStd(Level::Error, "Messages",
                 std::to_string(refused_) + " refused, the last because " + refusal_);
  } else {
    deleteStatus("Messages");
  }
  tellLayer();
  tellDoors();
}

void LtrMapDisplay::tellTriangles() {
  std::string sentence = std::to_string(ltrs_.size()) + " triangles";
  Level level = Level::Ok;
  if (!has_ltrs_) {
    level = Level::Warn;
    sentence = "None have come on '" + ltr_topic_->getTopicStd() + "'. Is hymm_grid running?";
  } else if (incomplete_ > 0) {
    level = Level::Warn;
    sentence += ", " + std::to_string(incomplete_) +
                " of them not drawn: their landmarks are not in the map (the triangles are of its "
                "version " +
                std::to_string(landmark_version_) + ", it is at " +
                std::to_string(feed_.map().version) + ")";
  }
  setStatusStd(level, "Triangles", sentence);
}

void LtrMapDisplay::tellLayer() {
  const std::string chosen = layer_->getStdString();
  const std::set<std::string> layers = textures_.layers();
  std::string known;
  for (const std::string& name : layers) known += (known.empty() ? "" : ", ") + name;
  if (chosen == kNoLayer || layers.count(chosen) > 0) {
    std::string painted = std::to_string(textures_.painted()) + " triangles with '" + chosen +
                          "' on " + std::to_string(textures_.pages()) + " pages";
    if (!textures_.range().isEmpty()) {
      painted += ", " + std::to_string(textures_.range().low) + " to " +
                 std::to_string(textures_.range().high);
    }
    setStatusStd(Level::Ok, "Layer", painted);
  } else {
    setStatusStd(Level::Warn, "Layer",
                 known.empty() ? "None has come on '" + grid_topic_->getTopicStd() + "'"
                               : "There is no layer '" + chosen + "'; there are: " + known);
  }
}

void LtrMapDisplay::tellDoors() {
  if (!door_frame_.empty() && feed_.hasMap() && door_frame_ != feed_.frame()) {
    setStatusStd(Level::Error, "Doors",
                 "Doors are in the frame '" + door_frame_ + "', landmarks in '" + feed_.frame() +
                     "': they are not drawn where they belong.");
  } else {
    setStatusStd(Level::Ok, "Doors", std::to_string(doors_.size()) + " doors");
  }
}

void LtrMapDisplay::tellRate(float wall_dt) {
  ++frames_;
  rate_window_s_ += wall_dt;
  if (rate_window_s_ < kRateWindow_s) return;
  ROS_DEBUG_NAMED("ltr_map", "%.1f frames a second with %zu triangles, %zu textured on %d pages",
                  static_cast<double>(static_cast<float>(frames_) / rate_window_s_), ltrs_.size(),
                  textures_.painted(), textures_.pages());
  frames_ = 0;
  rate_window_s_ = 0.0F;
}

}  // namespace hymm

PLUGINLIB_EXPORT_CLASS(hymm::LtrMapDisplay, rviz::Display)
