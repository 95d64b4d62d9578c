#include "pipeline/door_stage.h"

#include <limits>
#include <map>

#include "common/cpu_timer.h"
#include "common/error.h"
#include "common/unfinished_file.h"
#include "pipeline/csv_line.h"
#include "pipeline/plan_check.h"

namespace hymm::core {
namespace {

/// The landmarks, and those vertices of a map from elsewhere that are not among them.
std::vector<LandmarkEstimate> withVertices(const LandmarkMap& landmarks, const LtrMesh& mesh) {
  std::map<int, LandmarkEstimate> all;
  for (const LandmarkEstimate& landmark : landmarks.landmarks) all[landmark.id] = landmark;
  for (const int id : mesh.vertexLandmarks()) {
    LandmarkEstimate vertex;
    vertex.id = id;
    vertex.diameter_m = std::numeric_limits<double>::quiet_NaN();
    LandmarkEstimate& known = all.emplace(id, vertex).first->second;
    known.position = mesh.vertex(mesh.findVertex(id)).position;
  }
  std::vector<LandmarkEstimate> list;
  for (const auto& [id, landmark] : all) list.push_back(landmark);
  return list;
}

}  // namespace

void feedFrom(const GridMapper& mapper, const LandmarkMap& landmarks, PlannerFeed& feed) {
  const HybridMap& map = mapper.map();
  const std::vector<LtrTopology> topology = mapper.topology();
  feed.setTopology(topology);
  feed.setLandmarks(withVertices(landmarks, map.partition().mesh()));
  for (const LtrTopology& ltr : topology) {
    const LtrCells* cells = map.cells(ltr.id);
    for (int layer = 0; layer < map.layers().count(); ++layer) {
      if (cells->store.isEmpty(layer)) continue;
      feed.setLayer(ltr.id, map.layers().name(layer), map.layers().modelText(layer),
                    map.layers().channels(layer), cells->store.content(layer));
    }
  }
}

std::string planText(const Plan& plan) {
  std::string text = "x,y,ltr,landmark_1,landmark_2,landmark_3,weight_1,weight_2,weight_3\n";
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    const PlanPoint& point = plan.points[i];
    text += csvLine(',', plan.path[i].x(), plan.path[i].y(), point.ltr, point.landmark_ids[0],
                    point.landmark_ids[1], point.landmark_ids[2], point.weights[0],
                    point.weights[1], point.weights[2]) +
            "\n";
  }
  return text;
}

std::string doorsText(const DoorGraph& graph) {
  std::string text = "x,y,door,landmark_1,landmark_2\n";
  for (int portal = 0; portal < graph.portalCount(); ++portal) {
    const GraphSide& side = graph.side(graph.sideOf(portal));
    const GraphLtr& ltr = graph.ltr(side.ltrs[0]);
    for (int k = 0; k < 3; ++k) {
      if (ltr.sides[std::size_t(k)] != graph.sideOf(portal)) continue;
      const SideKey key = sideKeyOf(ltr.view, k);
      text += csvLine(',', graph.placeOf(portal).x(), graph.placeOf(portal).y(),
                      std::size_t(graph.doorOf(portal)), key.first, key.second) +
              "\n";
    }
  }
  return text;
}

DoorStage::DoorStage(const DoorPlannerConfig& config) : config_(config) {
  const std::vector<std::string> problems = config.problems();
  if (!problems.empty()) throw ConfigError(problems);
}

void DoorStage::takeScan(const ScanStep& step, CekfSlam&) {
  T_map_base_ = step.outcome.pose.T_map_base;
  outcome_.reset();
  if (step.map) landmarks_.take(*step.map);
  landmarks_.take(step.update);
}

void DoorStage::reset(double) {
  T_map_base_.reset();
  landmarks_ = LandmarkMirror();
}

bool DoorStage::hasWork() const {
  return mapper_ != nullptr && T_map_base_ && (config_.goalPlace() || config_.check_queries > 0);
}

const DoorStage::Outcome& DoorStage::outcome() const {
  if (outcome_) return *outcome_;
  outcome_.emplace();
  if (!hasWork()) return *outcome_;
  const CpuTimer timer(cpu_s_);
  PlannerFeed feed;
  DoorPlanner planner(config_);
  feedFrom(*mapper_, landmarks_.map(), feed);
  feed.tell(planner);
  outcome_->unusable = feed.unusable();
  planner.prepare(T_map_base_->position());
  planner.prepareDistricts();
  outcome_->doors = doorsText(*planner.graph());
  if (const std::optional<Eigen::Vector2d> goal = config_.goalPlace()) {
    PlanRequest request;
    request.start = T_map_base_->position();
    request.goal = *goal;
    request.start_heading = T_map_base_->yaw_rad;
    request.is_refined = config_.refinement.enabled;
    request.tolerance_m = config_.tolerance_m;
    outcome_->plan = planner.plan(request);
  }
  if (config_.check_queries > 0) {
    outcome_->queries =
        checkQueries(planner, mapper_->map(), landmarks_.map(), config_.check_queries);
  }
  return *outcome_;
}

void DoorStage::addTo(RunTotals& totals) const { totals.subsystem_cpu_s[kName] = cpu_s_; }

std::map<std::string, std::size_t> DoorStage::incidents() const {
  std::map<std::string, std::size_t> incidents;
  for (const auto& [words, count] : countsOf(outcome().unusable)) {
    incidents["LTRs left out of plans: each " + words] = count;
  }
  const Plan& plan = outcome().plan;
  if (config_.goalPlace() && !plan.ok()) {
    const std::string why = nameOf(plan.status) + ": " + plan.sentence;
    incidents["goals that were not planned to (" + why + ")"] = 1;
  }
  return incidents;
}

void DoorStage::write(const std::filesystem::path& folder) {
  if (!hasWork()) return;
  replaceFile(folder / "doors.csv", outcome().doors);
  if (config_.goalPlace()) replaceFile(folder / "plan.csv", planText(outcome().plan));
  if (config_.check_queries > 0) replaceFile(folder / "plan_queries.csv", outcome().queries);
}

}  // namespace hymm::core
