#include "door_planner/door_planner.h"

#include <utility>

#include "door_planner/plan_query.h"

namespace hymm::core {

struct DoorPlanner::Searches {
  std::mutex mutex;
  std::vector<std::unique_ptr<DoorSearch>> idle;

  std::unique_ptr<DoorSearch> take() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (idle.empty()) return std::make_unique<DoorSearch>();
    std::unique_ptr<DoorSearch> search = std::move(idle.back());
    idle.pop_back();
    return search;
  }
  void giveBack(std::unique_ptr<DoorSearch> search) {
    const std::lock_guard<std::mutex> lock(mutex);
    idle.push_back(std::move(search));
  }
};

DoorPlanner::DoorPlanner(const DoorPlannerConfig& config)
    : config_(config),
      map_(config),
      graph_(std::make_shared<DoorGraph>()),
      searches_(std::make_unique<Searches>()),
      weighted_maps_(config) {}

DoorPlanner::~DoorPlanner() = default;

UnusableLtrs DoorPlanner::setLtrs(const std::vector<LtrView>& ltrs) {
  weighted_maps_.setLtrs(ltrs);
  return map_.setLtrs(ltrs);
}

void DoorPlanner::setLandmarks(const std::vector<SolidLandmark>& landmarks) {
  weighted_maps_.setLandmarks(landmarks);
  map_.setLandmarks(landmarks);
}

bool DoorPlanner::setContent(int ltr, std::shared_ptr<const LtrContent> content) {
  if (!map_.setContent(ltr, *content)) return false;
  weighted_maps_.setContent(ltr, std::move(content));
  return true;
}

std::size_t DoorPlanner::prepare(const Eigen::Vector2d& place, std::size_t max_matrices) {
  const std::size_t left = map_.prepare(place, max_matrices);
  std::shared_ptr<const DoorGraph> made = map_.makeGraph();
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  graph_ = std::move(made);
  return left;
}

std::size_t DoorPlanner::prepareDistricts(std::size_t max_matrices) {
  if (config_.district_m == 0.0) return 0;
  const std::shared_ptr<const Districts> before = districts_;
  const bool is_same = before && before->graph() == graph_;
  const auto made = std::make_shared<const Districts>(
      (is_same ? *before : Districts(graph_, config_.district_m, before.get()))
          .withMatrices(max_matrices, district_search_));
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  districts_ = made;
  return made->missing();
}

std::shared_ptr<const Districts> DoorPlanner::districts() const {
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  return districts_ && districts_->graph() == graph_ ? districts_ : nullptr;
}

std::shared_ptr<const DoorGraph> DoorPlanner::graph() const {
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  return graph_;
}

Plan DoorPlanner::plan(const PlanRequest& request) const {
  Plan refused;
  const std::shared_ptr<const Districts> near = request.weights.empty() ? districts() : nullptr;
  std::shared_ptr<const DoorGraph> now;
  if (near) {
    now = near->graph();
  } else if (request.weights.empty()) {
    now = graph();
  } else {
    now = weighted_maps_.graphFor(request.weights, request.start, request.interrupted, refused);
  }
  if (!now) return refused;
  std::unique_ptr<DoorSearch> search = searches_->take();
  Plan plan = PlanQuery(*now, near.get(), config_, request).run(*search);
  searches_->giveBack(std::move(search));
  plan.sentence += weighted_maps_.remarkOn(request.weights);
  return plan;
}

std::optional<std::size_t> DoorPlanner::findBlocked(
    const std::vector<Eigen::Vector2d>& path) const {
  const std::shared_ptr<const DoorGraph> now = graph();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int ltr = now->locate(path[i - 1]);
    if (ltr == kNone || now->integrateFromAny(ltr, path[i - 1], path[i]) == kNoPassing) return i;
  }
  return std::nullopt;
}

}  // namespace hymm::core
