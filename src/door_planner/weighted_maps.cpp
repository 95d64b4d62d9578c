#include "door_planner/weighted_maps.h"

#include <algorithm>
#include <set>
#include <utility>

#include "door_planner/plan_query.h"

namespace hymm::core {
namespace {

constexpr std::size_t kKept = 2;             ///< sets of weights, each with matrices of its own
constexpr std::size_t kMatricesAtOnce = 20;  ///< between questions whether to go on

}  // namespace

void WeightedMaps::setLtrs(const std::vector<LtrView>& ltrs) {
  const std::lock_guard<std::mutex> lock(map_mutex_);
  ltrs_ = ltrs;
  std::map<int, std::shared_ptr<const LtrContent>> kept;
  for (const LtrView& ltr : ltrs) {
    const auto content = contents_.find(ltr.id);
    if (content != contents_.end()) kept.insert(*content);
  }
  contents_ = std::move(kept);
  ++version_;
}

void WeightedMaps::setLandmarks(const std::vector<SolidLandmark>& landmarks) {
  const std::lock_guard<std::mutex> lock(map_mutex_);
  landmarks_ = landmarks;
  ++version_;
}

void WeightedMaps::setContent(int ltr, std::shared_ptr<const LtrContent> content) {
  const std::lock_guard<std::mutex> lock(map_mutex_);
  contents_[ltr] = std::move(content);
  ++version_;
}

WeightedMaps::Variant* WeightedMaps::find(const std::string& weights, Plan& refused) {
  const auto same = std::find_if(variants_.begin(), variants_.end(),
                                 [&](const auto& variant) { return variant->weights == weights; });
  if (same != variants_.end()) {
    variants_.splice(variants_.begin(), variants_, same);
    return variants_.front().get();
  }
  DoorPlannerConfig config = config_;
  std::vector<std::string> problems;
  config.cost = config_.cost.with(weights, problems);
  if (problems.empty()) problems = config.problems();
  if (!problems.empty()) {
    std::string sentence = "The weights cannot be used.";
    for (const std::string& problem : problems) sentence += " " + problem;
    refused = refusedPlan(PlanStatus::kBadRequest, sentence);
    return nullptr;
  }
  variants_.push_front(std::make_shared<Variant>(weights, config));
  if (variants_.size() > kKept) variants_.pop_back();
  return variants_.front().get();
}

void WeightedMaps::tell(Variant& variant) {
  const std::lock_guard<std::mutex> lock(map_mutex_);
  if (variant.version == version_) return;
  variant.version = version_;
  variant.graph.reset();
  variant.map.setLtrs(ltrs_);
  variant.map.setLandmarks(landmarks_);
  for (const auto& [ltr, content] : contents_) {
    if (variant.contents[ltr] != content) variant.map.setContent(ltr, *content);
  }
  variant.contents = contents_;
}

std::string WeightedMaps::remarkOn(const std::string& weights) const {
  if (weights.empty()) return "";
  std::set<std::string> held;
  {
    const std::lock_guard<std::mutex> lock(map_mutex_);
    for (const auto& [ltr, content] : contents_) {
      for (const auto& [layer, values] : content->properties) held.insert(layer);
    }
  }
  std::string names = "distance, occupancy, unknown";
  for (const std::string& layer : held) names += ", " + layer;
  std::string remark;
  std::vector<std::string> problems;  // told before, with the plan
  for (const PropertyWeight& weight : PathCostConfig().with(weights, problems).weights(problems)) {
    const std::string layer = weight.property.substr(0, weight.property.find('>'));
    if (held.count(layer) > 0) continue;
    remark += " No LTR holds anything of '" + layer +
              "', whose weight changes nothing; there are " + names + ".";
  }
  return remark;
}

std::shared_ptr<const DoorGraph> WeightedMaps::graphFor(
    const std::string& weights, const Eigen::Vector2d& place,
    const std::function<PlanStatus()>& interrupted, Plan& refused) {
  const std::lock_guard<std::mutex> lock(variants_mutex_);
  Variant* variant = find(weights, refused);
  if (variant == nullptr) return nullptr;
  tell(*variant);
  if (variant->graph) return variant->graph;
  while (variant->map.prepare(place, kMatricesAtOnce) > 0) {
    const PlanStatus status = interrupted ? interrupted() : PlanStatus::kOk;
    if (status == PlanStatus::kOk) continue;
    refused = refusedPlan(status, status == PlanStatus::kCancelled
                                      ? "The request was cancelled."
                                      : "Costs by these weights were not computed within the time "
                                        "that was given; ask again, what is done is kept.");
    return nullptr;
  }
  variant->graph = variant->map.makeGraph();
  return variant->graph;
}

}  // namespace hymm::core
