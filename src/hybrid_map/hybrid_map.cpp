#include "hybrid_map/hybrid_map.h"

#include <cmath>
#include <limits>
#include <sstream>

#include "common/error.h"
#include "common/state_archive.h"
#include "hybrid_map/input_check.h"
#include "hybrid_map/layer_writer.h"
#include "hybrid_map/log_odds.h"
#include "hybrid_map/scan_writer.h"
#include "perception/scan_check.h"

namespace hymm::core {
namespace {

HybridMapConfig checked(const HybridMapConfig& config) {
  const std::vector<std::string> problems = config.problems();
  if (!problems.empty()) throw ConfigError(problems);
  return config;
}

LogOddsLimits limitsOf(const OccupancyConfig& occupancy) {
  return {static_cast<float>(logOddsOf(occupancy.min_probability)),
          static_cast<float>(logOddsOf(occupancy.max_probability))};
}

}  // namespace

class HybridMap::Impl {
 public:
  explicit Impl(const HybridMapConfig& config)
      : config_(checked(config)),
        layers_(config.layers, config.day_parts, ignored_problems_, limitsOf(config.occupancy)),
        partition_(config.partition),
        writer_(config, layers_),
        scan_writer_(config.occupancy, partition_),
        traffic_(config.traffic, layers_, config.resolution_m, ignored_problems_) {}

  MapOutcome apply(const LandmarkMap& map) {
    ++counts_.landmark_maps;
    if (auto problem = landmarkProblem(map.landmarks)) {
      return refuse(*problem, counts_.refused_landmarks);
    }
    MapOutcome outcome = map.version < version_ ? growBy(map) : follow(map);
    writer_.waiting().join(map, landmarks_, config_.max_pose_deviation_m, revision_);
    return outcome;
  }

  MapOutcome apply(const LandmarkUpdate& update) {
    ++counts_.landmark_updates;
    if (update.version < version_) {
      return refuse(olderThanHeld(update.version), counts_.refused_landmarks);
    }
    if (update.since_version > version_) {
      return refuse("the update tells what changed since version " +
                        std::to_string(update.since_version) + ", but version " +
                        std::to_string(version_) + " is held: a whole map is needed first",
                    counts_.refused_landmarks);
    }
    if (auto problem = landmarkProblem(update.changed)) {
      return refuse(*problem, counts_.refused_landmarks);
    }
    return follow(update);
  }

  MapOutcome insert(const PosedScan& posed) {
    if (auto problem = scanRefusal(posed)) return refuse(*problem, counts_.refused_scans);
    ++counts_.scans;
    ++revision_;
    writer_.begin(posed.T_map_laser.position(), landmarks_, revision_);
    if (traffic_.isOn()) countTraffic(posed);
    counts_.beams += scan_writer_.write(posed.scan, posed.T_map_laser, writer_);
    vehicle_ = posed.T_map_laser.position();
    keepWithinMemory();
    return accepted();
  }

  MapOutcome insert(const PropertySample& sample) {
    if (auto problem = problemWith(sample, layers_, config_.max_sample_deviation_m)) {
      return refuse(*problem, counts_.refused_samples);
    }
    ++counts_.samples;
    ++revision_;
    writer_.begin(sample.position, landmarks_, revision_);
    const int layer = layers_.find(sample.layer);
    const auto places = likelyPlaces(sample, config_.resolution_m);
    const double share = 1.0 / static_cast<double>(places.size());
    for (const Eigen::Vector2d& place : places) {
      writer_.addSample(partition_, layer, place, sample.sample, share);
    }
    keepWithinMemory();
    return accepted();
  }

  std::vector<LtrTopology> topology(const LandmarkMap& map) const {
    std::vector<LtrTopology> topology = topologyOf(partition_, map);
    for (LtrTopology& ltr : topology) {
      const TriangularGrid& grid = writer_.find(ltr.id)->grid;
      ltr.alpha_cells = grid.alphaCells();
      ltr.beta_cells = grid.betaCells();
    }
    return topology;
  }

  std::vector<ChangedLayer> changedSince(std::uint64_t revision) const {
    std::vector<ChangedLayer> changed;
    for (int ltr = 0; ltr < partition_.mesh().ltrEnd(); ++ltr) {
      const LtrCells* cells = writer_.find(ltr);
      for (int layer = 0; cells != nullptr && layer < layers_.count(); ++layer) {
        const std::uint64_t written = cells->store.revision(layer);
        if (written > revision) changed.push_back({ltr, layer, written});
      }
    }
    return changed;
  }

  LayerQuery query(const std::string& name, const Eigen::Vector2d& place) const {
    LayerQuery answer;
    const int layer = layers_.find(name);
    if (layer < 0) {
      answer.status = LayerQuery::Status::kNoSuchLayer;
      return answer;
    }
    answer.ltr = partition_.mesh().locate(place, query_hint_);
    query_hint_ = answer.ltr;
    if (answer.ltr == kNone) {
      answer.status = LayerQuery::Status::kOutside;
    } else if (const float* cell = cellAt(answer.ltr, layer, place)) {
      answer.value = layers_.model(layer).read(cell);
      if (answer.value) answer.status = LayerQuery::Status::kKnown;
    }
    return answer;
  }

  float occupancyLogOdds(const Eigen::Vector2d& place) const {
    query_hint_ = partition_.mesh().locate(place, query_hint_);
    if (query_hint_ == kNone) return 0.0F;
    const float* cell = cellAt(query_hint_, LayerSet::kOccupancy, place);
    return cell == nullptr ? 0.0F : *cell;
  }

  std::vector<float> renderOccupancy(const Eigen::Vector2d& low, int width, int height,
                                     double resolution_m) const {
    std::vector<float> image(std::size_t(width) * std::size_t(height),
                             std::numeric_limits<float>::quiet_NaN());
    int hint = kNone;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const Eigen::Vector2d place = low + resolution_m * Eigen::Vector2d(x + 0.5, y + 0.5);
        const int ltr = partition_.mesh().locate(place, hint);
        if (ltr == kNone) continue;
        hint = ltr;
        const float* cell = cellAt(ltr, LayerSet::kOccupancy, place);
        if (cell != nullptr && *cell != 0.0F) {
          image[std::size_t(y) * std::size_t(width) + std::size_t(x)] = *cell;
        }
      }
    }
    return image;
  }

  const HybridMapConfig& config() const { return config_; }
  const LayerSet& layers() const { return layers_; }
  const LtrPartition& partition() const { return partition_; }
  const LayerWriter& writer() const { return writer_; }
  const Counts& counts() const { return counts_; }
  std::uint64_t version() const { return version_; }
  std::uint64_t revision() const { return revision_; }
  void continueFrom(const Impl& before) {
    counts_ = before.counts_;
    revision_ = std::max(revision_, before.revision_ + 1);
  }

  std::string saveState() const {
    StateWriter archive;
    archive(std::string(kStateKind), kStateVersion, layerTexts(), config_.resolution_m,
            config_.day_parts, landmarks_, partition_);
    writer_.save(archive);
    archive(traffic_, version_, revision_, vehicle_, packed_from_, packed_revision_);
    return archive.takeBytes();
  }

  void restoreState(StateReader& archive) {
    archive.require(archive.read<std::string>() == kStateKind, "it holds no dense map");
    archive.requireSame(archive.read<std::uint32_t>() == kStateVersion,
                        "it is of another version of hymm; load it with that.");
    const auto layers = archive.read<std::vector<std::string>>();
    archive.requireSame(layers == layerTexts(), "it has other layers (" + listOf(layers) +
                                                    "); start hymm_grid with these.");
    const auto resolution_m = archive.read<double>();
    const auto day_parts = archive.read<int>();
    archive.requireSame(resolution_m == config_.resolution_m && day_parts == config_.day_parts,
                        "its resolution_m is " + std::to_string(resolution_m) +
                            " and its day_parts are " + std::to_string(day_parts) +
                            "; start hymm_grid with these.");
    archive(landmarks_, partition_);
    writer_.restore(partition_, archive);
    archive(traffic_, version_, revision_, vehicle_, packed_from_, packed_revision_);
    archive.requireEnd();
  }

  void belongTo(std::uint64_t landmark_version) { version_ = landmark_version; }

 private:
  static constexpr const char* kStateKind = "hymm dense map";
  static constexpr std::uint32_t kStateVersion = 4;

  std::vector<std::string> layerTexts() const {
    std::vector<std::string> texts;
    for (int i = 0; i < layers_.count(); ++i) {
      texts.push_back(layers_.name(i) + " " + layers_.modelText(i));
    }
    return texts;
  }
  static std::string listOf(const std::vector<std::string>& texts) {
    std::string list;
    for (const std::string& text : texts) list += (list.empty() ? "" : "; ") + text;
    return list;
  }

  static MapOutcome refuse(const std::string& reason, std::size_t& count) {
    ++count;
    MapOutcome outcome;
    outcome.reason = reason;
    return outcome;
  }
  static MapOutcome accepted() {
    MapOutcome outcome;
    outcome.accepted = true;
    return outcome;
  }

  std::string olderThanHeld(std::uint64_t version) const {
    return "version " + std::to_string(version) + " of the landmarks is older than version " +
           std::to_string(version_) + ", which is held";
  }

  void countTraffic(const PosedScan& posed) {
    const int edge = std::max(1, static_cast<int>(traffic_.square_m() / config_.resolution_m));
    const double step = traffic_.square_m() / edge;
    const auto take = [&](const Eigen::Vector2d& centre, const LayerSample& sample) {
      for (int j = 0; j < edge; ++j) {
        for (int i = 0; i < edge; ++i) {
          const Eigen::Vector2d off(i + 0.5 - 0.5 * edge, j + 0.5 - 0.5 * edge);
          writer_.addSample(partition_, traffic_.layer(), centre + step * off, sample, 1.0);
        }
      }
    };
    counts_.moving_objects += traffic_.look(
        posed.scan, posed.T_map_laser, config_.occupancy,
        [this](const Eigen::Vector2d& place) { return occupancyLogOdds(place); }, take);
  }

  /// Compresses once a tenth of the radius is driven, before which hardly anything comes to lie
  /// beyond, and now and then, since what is looked at unpacks itself.
  void keepWithinMemory() {
    constexpr std::uint64_t kInputs = 200;
    const bool has_driven =
        !packed_from_ || (*packed_from_ - vehicle_).norm() >= 0.1 * config_.active_radius_m;
    if (has_driven || revision_ >= packed_revision_ + kInputs) {
      packed_from_ = vehicle_;
      packed_revision_ = revision_;
      writer_.packBeyond(partition_, vehicle_);
      counts_.forgotten_ltrs += writer_.forgetBeyondLimit(partition_);
    }
    counts_.dropped_waiting_tiles += writer_.waiting().dropBeyondLimit(vehicle_);
  }

  /// A map takes longer to make than an update, which may have overtaken it: what it says of
  /// covariances still holds, while places are known better.
  MapOutcome growBy(LandmarkMap map) {
    std::vector<LandmarkEstimate> present;
    for (LandmarkEstimate& landmark : map.landmarks) {
      const auto place = landmarks_.findUnmerged(landmark.id);
      if (!place) continue;
      landmark.position = *place;
      present.push_back(landmark);
    }
    map.landmarks = std::move(present);
    ++revision_;
    MapOutcome outcome = accepted();
    outcome.change = partition_.grow(map);
    return entail(std::move(outcome));
  }

  template <class Landmarks>
  MapOutcome follow(const Landmarks& landmarks) {
    version_ = landmarks.version;
    ++revision_;
    MapOutcome outcome = accepted();
    outcome.change = partition_.apply(landmarks);
    landmarks_.apply(landmarks);
    return entail(std::move(outcome));
  }

  MapOutcome entail(MapOutcome outcome) {
    writer_.follow(partition_, outcome.change, landmarks_, revision_);
    counts_.ltrs_created += outcome.change.created.size();
    counts_.ltrs_retired += outcome.change.retired.size();
    counts_.dropped_waiting_tiles += writer_.waiting().dropBeyondLimit(vehicle_);
    return outcome;
  }

  std::optional<std::string> scanRefusal(const PosedScan& posed) const {
    if (auto problem = scanProblem(posed.scan)) return problem;
    const Pose2& pose = posed.T_map_laser;
    if (!isPlace(pose.position()) || !std::isfinite(pose.yaw_rad)) return "the pose is not finite";
    if (posed.map_version != version_) {
      return "the pose belongs to version " + std::to_string(posed.map_version) +
             " of the landmarks, but version " + std::to_string(version_) + " is held";
    }
    // Written so that what is not a number is refused.
    const bool is_certain = posed.pose_deviation_m <= config_.max_pose_deviation_m &&
                            posed.heading_deviation_rad <= config_.max_heading_deviation_rad;
    if (is_certain) return std::nullopt;
    std::ostringstream text;
    text << "the pose is not certain enough relative to the landmarks: " << posed.pose_deviation_m
         << " m and " << posed.heading_deviation_rad << " rad";
    return text.str();
  }

  const float* cellAt(int ltr, int layer, const Eigen::Vector2d& place) const {
    const LtrCells* cells = writer_.find(ltr);
    if (cells == nullptr || cells->store.isEmpty(layer)) return nullptr;
    const int index = cells->grid.index(partition_.mesh().ltr(ltr).triangle.toLocal(place));
    return cells->store.read(layers_, layer, index);
  }

  HybridMapConfig config_;
  std::vector<std::string> ignored_problems_;  // checked() has told them
  LayerSet layers_;
  LandmarkPlaces landmarks_;
  LtrPartition partition_;
  LayerWriter writer_;
  ScanWriter scan_writer_;
  TrafficCounter traffic_;
  std::uint64_t version_ = 0;
  std::uint64_t revision_ = 0;
  Eigen::Vector2d vehicle_ = Eigen::Vector2d::Zero();  ///< the sensor's place at the last scan
  std::optional<Eigen::Vector2d> packed_from_;         ///< where that was when cells were packed
  std::uint64_t packed_revision_ = 0;
  mutable int query_hint_ = kNone;
  Counts counts_;
};

HybridMap::HybridMap(const HybridMapConfig& config) : impl_(std::make_unique<Impl>(config)) {}
HybridMap::~HybridMap() = default;
HybridMap::HybridMap(HybridMap&&) noexcept = default;
HybridMap& HybridMap::operator=(HybridMap&&) noexcept = default;

MapOutcome HybridMap::apply(const LandmarkMap& map) { return impl_->apply(map); }
MapOutcome HybridMap::apply(const LandmarkUpdate& update) { return impl_->apply(update); }
MapOutcome HybridMap::insert(const PosedScan& scan) { return impl_->insert(scan); }
MapOutcome HybridMap::insert(const PropertySample& sample) { return impl_->insert(sample); }

void HybridMap::reset() {
  auto fresh = std::make_unique<Impl>(impl_->config());
  fresh->continueFrom(*impl_);
  impl_ = std::move(fresh);
}

std::string HybridMap::saveState() const { return impl_->saveState(); }

void HybridMap::checkState(std::string_view bytes, const std::string& name) const {
  StateReader archive(bytes, name);
  Impl(impl_->config()).restoreState(archive);
}

void HybridMap::loadState(std::string_view bytes, const std::string& name,
                          std::uint64_t landmark_version) {
  StateReader archive(bytes, name);
  auto loaded = std::make_unique<Impl>(impl_->config());
  loaded->restoreState(archive);
  loaded->belongTo(landmark_version);
  loaded->continueFrom(*impl_);
  impl_ = std::move(loaded);
}

std::uint64_t HybridMap::landmarkVersion() const { return impl_->version(); }
std::uint64_t HybridMap::revision() const { return impl_->revision(); }
std::vector<int> HybridMap::pinnedLandmarks() const { return impl_->partition().pinnedLandmarks(); }
std::vector<LtrTopology> HybridMap::topology(const LandmarkMap& map) const {
  return impl_->topology(map);
}
std::vector<ChangedLayer> HybridMap::changedSince(std::uint64_t revision) const {
  return impl_->changedSince(revision);
}
const LtrCells* HybridMap::cells(int ltr) const { return impl_->writer().find(ltr); }
const LayerSet& HybridMap::layers() const { return impl_->layers(); }
LayerQuery HybridMap::query(const std::string& layer, const Eigen::Vector2d& place) const {
  return impl_->query(layer, place);
}
float HybridMap::occupancyLogOdds(const Eigen::Vector2d& place) const {
  return impl_->occupancyLogOdds(place);
}
double HybridMap::resolution_m() const { return impl_->config().resolution_m; }
std::vector<float> HybridMap::renderOccupancy(const Eigen::Vector2d& low, int width, int height,
                                              double resolution_m) const {
  return impl_->renderOccupancy(low, width, height, resolution_m);
}
double HybridMap::evidenceInLtrs(int layer) const { return impl_->writer().evidence(layer); }
double HybridMap::evidenceWaiting(int layer) const {
  return impl_->writer().waiting().evidence(layer);
}
CellMemory HybridMap::ltrMemory() const { return impl_->writer().memory(); }
CellMemory HybridMap::waitingMemory() const { return impl_->writer().waiting().memory(); }
const LtrPartition& HybridMap::partition() const { return impl_->partition(); }
const WaitingTiles& HybridMap::waiting() const { return impl_->writer().waiting(); }
const HybridMap::Counts& HybridMap::counts() const { return impl_->counts(); }

}  // namespace hymm::core
