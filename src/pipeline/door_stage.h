#pragma once

#include <string>
#include <vector>

#include "door_planner/door_planner.h"
#include "door_planner/planner_feed.h"
#include "pipeline/grid_mapper.h"
#include "pipeline/landmark_mirror.h"
#include "pipeline/suite_stage.h"

namespace hymm::core {

/// Tells the feed all that a hybrid map holds now, topology, places of the vertices and layers, and
/// the landmarks of the same version.
void feedFrom(const GridMapper& mapper, const LandmarkMap& landmarks, PlannerFeed& feed);

/// The content of plan.csv: a line a point, with the landmarks that it moves with.
std::string planText(const Plan& plan);

/// The content of doors.csv: a line a portal, with its door and the landmarks of its side.
std::string doorsText(const DoorGraph& graph);

/// The engine of the node `door_planner` in an offline run: at the end it plans over the map from
/// the last pose to the goal that is configured, and between random places if asked.
class DoorStage : public SuiteStage {
 public:
  static constexpr const char* kName = "door_planner";

  /// Throws ConfigError if the configuration is unusable.
  explicit DoorStage(const DoorPlannerConfig& config);

  /// The map to plan over, which outlives the object.
  void readMapOf(const GridMapper& mapper) { mapper_ = &mapper; }

  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path& folder) override;

 private:
  /// What is planned at the end, when it is first asked for.
  struct Outcome {
    Plan plan;
    std::string doors, queries;  ///< contents of files
    UnusableLtrs unusable;
  };
  bool hasWork() const;
  const Outcome& outcome() const;

  DoorPlannerConfig config_;
  const GridMapper* mapper_ = nullptr;
  std::optional<Pose2> T_map_base_;
  LandmarkMirror landmarks_;
  mutable std::optional<Outcome> outcome_;
  mutable double cpu_s_ = 0.0;
};

}  // namespace hymm::core
