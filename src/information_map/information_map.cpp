#include "information_map/information_map.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hymm::core {

class InformationMap::Impl {
 public:
  Impl(const InformationMapConfig& config, const VehicleConfig& vehicle)
      : config_(config),
        vehicle_(vehicle),
        search_(std::in_place, config, occlusion()),
        evaluator_(config.information, occlusion()),
        field_(std::make_shared<const LandmarkField>()) {
    MotionModel{vehicle};  // refuses an unusable geometry at once
  }

  LevelSetUpdate apply(const LandmarkMap& map, const Pose2& T_map_base) {
    LevelSetUpdate outcome;
    if (counts_.maps > 0 && map.version < field_->version()) {
      outcome.refused = "Map version " + std::to_string(map.version) + " is older than " +
                        std::to_string(field_->version()) + ", which was used.";
    } else {
      auto field = std::make_shared<const LandmarkField>(map, config_.information.sensor.range_m);
      counts_.refused_landmarks += field->refusedLandmarks();
      counts_.refused_pairs += field->refusedPairs();
      outcome = search_->update(field, T_map_base.position());
      if (outcome.refused.empty()) {
        field_ = std::move(field);
        vehicle_place_ = T_map_base.position();
      }
    }
    ++(outcome.refused.empty() ? counts_.maps : counts_.refused_maps);
    counts_.evaluations += outcome.evaluations;
    if (!outcome.is_complete) ++counts_.unfinished_updates;
    return outcome;
  }

  void setDenseMap(const OccupancyImage& image) {
    auto sight = std::make_shared<const SightMap>(config_.dense_map, image);
    if (config_.dense_map.occlusion) {
      noteOccupiedUnlike(*sight, sight_.get());
      if (sight_) noteOccupiedUnlike(*sight_, sight.get());
    }
    sight_ = std::move(sight);
  }

  void reset() {
    search_.emplace(config_, occlusion());
    sight_.reset();
    field_ = std::make_shared<const LandmarkField>();
    vehicle_place_.setZero();
  }

  LevelSets levelSets() const {
    LevelSets all;
    all.map_version = all.computed_version = field_->version();
    all.time_s = field_->time_s();
    const LevelLattice& lattice = search_->lattice();
    all.resolution_m = lattice.resolution_m();
    for (int level = 1; level <= lattice.levels(); ++level) {
      const LevelIslands& islands = search_->islands(level);
      LevelSet set;
      set.value = search_->values()[std::size_t(level - 1)];
      set.area_m2 = lattice.area_m2(level);
      set.leaves = quadtreeLeaves(lattice, level, islands);
      set.islands = islands.islands();
      set.joined = islands.joined();
      set.vehicle_island = islands.islandOf(lattice, lattice.cellAt(vehicle_place_));
      all.sets.push_back(std::move(set));
    }
    return all;
  }

  LevelSets levelSetsMovedTo(const LandmarkMap& newer) const {
    LevelSets all = levelSets();
    const LandmarkField to(newer, config_.information.sensor.range_m);
    const LandmarkMotion motion(*field_, to, config_.information.sensor.range_m);
    all.map_version = newer.version;
    if (motion.largest_m() == 0.0) return all;
    for (LevelSet& set : all.sets) {
      for (LevelLeaf& leaf : set.leaves) leaf.centre = motion.move(leaf.centre);
    }
    return all;
  }

  AchievableInformation evaluate(const Pose2& T_map_base) {
    const Pose2 T_base_sensor = vehicle_.laser.T_base_sensor();
    AchievableInformation information = evaluator_.at(*field_, T_map_base * T_base_sensor);
    information.matrix = informationOnBase(information.matrix, T_map_base, T_base_sensor);
    information.value = evaluator_.measure().of(information.matrix);
    return information;
  }

  AchievableInformation evaluatePlace(const Eigen::Vector2d& p_map_sensor) {
    return evaluator_.at(*field_, p_map_sensor);
  }

  ExplorationAnswer suggestExploration(const ExplorationRequest& request) const {
    ExplorationAnswer answer;
    if (request.level < 1 || request.level > search_->lattice().levels()) {
      answer.problem = "There is no level set of so low a value; the lowest is " +
                       std::to_string(search_->values().front()) + " per m^2.";
      return answer;
    }
    ExplorationPlanner::IsFree is_free;
    if (sight_) {
      is_free = [this](const Eigen::Vector2d& place) {
        return sight_->isFree(place, 0.5 * vehicle_.width_m);
      };
    }
    ExplorationPlanner planner(config_, vehicle_, search_->lattice(),
                               search_->islands(request.level), *field_, is_free, occlusion());
    return planner.suggest(request);
  }

  /// What hides landmarks, as of the dense map when it is asked; nothing if that is not wanted.
  InformationEvaluator::Occlusion occlusion() const {
    if (!config_.dense_map.occlusion) return nullptr;
    return [this](const Eigen::Vector2d& sensor, const Eigen::Vector2d& to) {
      return sight_ && sight_->hides(sensor, to);
    };
  }

  void noteOccupiedUnlike(const SightMap& sight, const SightMap* other) {
    search_->noteChangedLooks(sight.occupiedUnlike(other), std::sqrt(0.5) * sight.resolution_m(),
                              config_.dense_map.landmark_clearance_m);
  }

  InformationMapConfig config_;
  VehicleConfig vehicle_;
  std::shared_ptr<const SightMap> sight_;  ///< null until there is a dense map
  std::optional<LevelSetSearch> search_;
  InformationEvaluator evaluator_;
  std::shared_ptr<const LandmarkField> field_;
  Eigen::Vector2d vehicle_place_ = Eigen::Vector2d::Zero();
  Counts counts_;
};

InformationMap::InformationMap(const InformationMapConfig& config, const VehicleConfig& vehicle)
    : impl_(std::make_unique<Impl>(config, vehicle)) {}
InformationMap::~InformationMap() = default;
InformationMap::InformationMap(InformationMap&&) noexcept = default;
InformationMap& InformationMap::operator=(InformationMap&&) noexcept = default;

LevelSetUpdate InformationMap::apply(const LandmarkMap& map, const Pose2& T_map_base) {
  return impl_->apply(map, T_map_base);
}
void InformationMap::setDenseMap(const OccupancyImage& image) { impl_->setDenseMap(image); }
bool InformationMap::hasDenseMap() const { return impl_->sight_ != nullptr; }
void InformationMap::reset() { impl_->reset(); }
LevelSets InformationMap::levelSets() const { return impl_->levelSets(); }
LevelSets InformationMap::levelSetsMovedTo(const LandmarkMap& newer) const {
  return impl_->levelSetsMovedTo(newer);
}
AchievableInformation InformationMap::evaluate(const Pose2& T_map_base) const {
  return impl_->evaluate(T_map_base);
}
AchievableInformation InformationMap::evaluatePlace(const Eigen::Vector2d& p_map_sensor) const {
  return impl_->evaluatePlace(p_map_sensor);
}
ExplorationAnswer InformationMap::suggestExploration(const ExplorationRequest& request) const {
  return impl_->suggestExploration(request);
}
int InformationMap::levelOf(double value) const {
  const std::vector<double>& values = impl_->search_->values();
  return static_cast<int>(std::upper_bound(values.begin(), values.end(), value) - values.begin());
}
std::uint64_t InformationMap::mapVersion() const { return impl_->field_->version(); }
const InformationMapConfig& InformationMap::config() const { return impl_->config_; }
const LevelSetSearch& InformationMap::search() const { return *impl_->search_; }
const InformationMap::Counts& InformationMap::counts() const { return impl_->counts_; }

}  // namespace hymm::core
