#include "pipeline/information_stage.h"

#include "common/unfinished_file.h"
#include "pipeline/csv_line.h"

namespace hymm::core {
namespace {

std::string changeText(double time_s, const InformationMap& information,
                       const LevelSetUpdate& update) {
  std::string text;
  for (std::size_t i = 0; i < update.levels.size(); ++i) {
    const LevelChange& level = update.levels[i];
    text += csvLine(',', time_s, std::to_string(information.mapVersion()),
                    information.search().values()[i], level.area_m2, level.gained_m2, level.lost_m2,
                    level.lost_moving_m2, level.kept_m2,
                    information.search().islands(static_cast<int>(i) + 1).islands().size(),
                    update.evaluations) +
            "\n";
  }
  return text;
}

}  // namespace

InformationStage::InformationStage(const InformationMapConfig& config, const VehicleConfig& vehicle,
                                   const MapImageConfig& image)
    : information_(config, vehicle),
      needs_dense_map_(config.dense_map.occlusion),
      image_config_(image),
      image_(image),
      changes_(
          "t,map_version,value,area_m2,gained_m2,lost_m2,lost_moving_m2,kept_m2,islands,"
          "evaluations\n") {}

void InformationStage::takeScan(const ScanStep& step, CekfSlam&) {
  pose_ = step.outcome.pose;
  if (!step.map) return;
  const CpuTimer timer(cpu_s_);
  if (needs_dense_map_) takeDenseMap();
  const LevelSetUpdate update = information_.apply(*step.map, step.outcome.pose.T_map_base);
  if (update.refused.empty()) {
    changes_ += changeText(step.outcome.pose.time_s, information_, update);
  }
}

void InformationStage::takeDenseMap() {
  if (mapper_ == nullptr) return;
  image_.update(mapper_->map());
  if (!image_.image().cells.empty()) information_.setDenseMap(image_.image());
}

void InformationStage::reset(double) {
  information_.reset();
  image_ = MapImage(image_config_);
  pose_.reset();
}

void InformationStage::addTo(RunTotals& totals) const { totals.subsystem_cpu_s[kName] = cpu_s_; }

std::map<std::string, std::size_t> InformationStage::incidents() const {
  std::map<std::string, std::size_t> incidents;
  const auto add = [&](const char* what, std::size_t count) {
    if (count > 0) incidents[what] = count;
  };
  const InformationMap::Counts& counts = information_.counts();
  add("landmark maps that the information map refused", counts.refused_maps);
  add("changes of the map after which level_sets.max_evaluations left level sets unfinished",
      counts.unfinished_updates);
  add("landmarks that the information map refused: not finite, or with an unusable covariance",
      counts.refused_landmarks);
  return incidents;
}

void InformationStage::write(const std::filesystem::path& folder) {
  replaceFile(folder / "level_sets.csv", levelSetsText(information_.levelSets()));
  replaceFile(folder / "information_changes.csv", changes_);
  if (!pose_) return;
  takeDenseMap();
  ExplorationRequest request;
  request.T_map_base = pose_->T_map_base;
  request.covariance = pose_->covariance;
  replaceFile(folder / "exploration.csv",
              explorationText(information_.suggestExploration(request)));
}

std::string explorationText(const ExplorationAnswer& answer) {
  std::string text =
      "x,y,yaw,way_m,position_deviation_m,heading_deviation_rad,new_area_m2,joins_island\n";
  for (const ExplorationGoal& goal : answer.goals) {
    text += csvLine(',', goal.T_map_base.x_m, goal.T_map_base.y_m, goal.T_map_base.yaw_rad,
                    goal.way_m, goal.position_deviation_m, goal.heading_deviation_rad,
                    goal.new_area_m2, goal.joins_island) +
            "\n";
  }
  return text;
}

std::string levelSetsText(const LevelSets& sets) {
  std::string text = "value,x,y,edge,island\n";
  for (const LevelSet& set : sets.sets) {
    for (const LevelLeaf& leaf : set.leaves) {
      text += csvLine(',', set.value, leaf.centre.x(), leaf.centre.y(), leaf.edge_m, leaf.island) +
              "\n";
    }
  }
  return text;
}

}  // namespace hymm::core
