#include "door_planner/weighted_maps.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "door_planner/plan_query.h"

namespace hymm::core {
namespace {

constexpr std::size_t kKept = 2;  ///< sets of weights, each with matrices of its own
constexpr std::size_t kAllMatrices = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kContentsAtOnce = 200;  ///< between questions whether to go on
constexpr std::chrono::milliseconds kPatience{20};

Plan unprepared(PlanStatus status) {
  return refusedPlan(status, status == PlanStatus::kCancelled
                                 ? "The request was cancelled."
                                 : "Costs by these weights were not computed within the time that "
                                   "was given; ask again, what is done is kept.");
}

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

std::optional<DoorPlannerConfig> WeightedMaps::configFor(const std::string& weights,
                                                         Plan& refused) const {
  DoorPlannerConfig config = config_;
  std::vector<std::string> problems;
  config.cost = config_.cost.with(weights, problems);
  if (problems.empty()) problems = config.problems();
  if (problems.empty()) return config;
  std::string sentence = "The weights cannot be used.";
  for (const std::string& problem : problems) sentence += " " + problem;
  refused = refusedPlan(PlanStatus::kBadRequest, sentence);
  return std::nullopt;
}

/// One that nobody has taken; null if there is none. What is being prepared is not dropped for
/// another, so that there are never more than are kept.
std::shared_ptr<WeightedMaps::Variant> WeightedMaps::findFree(const std::string& weights,
                                                              const DoorPlannerConfig& config) {
  const auto same = std::find_if(variants_.begin(), variants_.end(),
                                 [&](const auto& variant) { return variant->weights == weights; });
  if (same != variants_.end()) {
    if ((*same)->is_taken) return nullptr;
    variants_.splice(variants_.begin(), variants_, same);
    return variants_.front();
  }
  if (variants_.size() >= kKept) {
    const auto unused = std::find_if(variants_.rbegin(), variants_.rend(),
                                     [](const auto& variant) { return !variant->is_taken; });
    if (unused == variants_.rend()) return nullptr;
    variants_.erase(std::next(unused).base());
  }
  variants_.push_front(std::make_shared<Variant>(weights, config));
  return variants_.front();
}

std::shared_ptr<WeightedMaps::Variant> WeightedMaps::take(const std::string& weights,
                                                          const Interrupted& interrupted,
                                                          Plan& refused) {
  const std::optional<DoorPlannerConfig> config = configFor(weights, refused);
  if (!config) return nullptr;
  std::unique_lock<std::mutex> lock(variants_mutex_);
  while (true) {
    std::shared_ptr<Variant> found = findFree(weights, *config);
    if (found) {
      found->is_taken = true;
      return found;
    }
    given_back_.wait_for(lock, kPatience);
    if (!interrupted) continue;
    lock.unlock();
    const PlanStatus status = interrupted();
    if (status != PlanStatus::kOk) {
      refused = unprepared(status);
      return nullptr;
    }
    lock.lock();
  }
}

void WeightedMaps::giveBack(Variant& variant) {
  const std::lock_guard<std::mutex> lock(variants_mutex_);
  variant.is_taken = false;
  given_back_.notify_all();
}

/// Tells it of the map as it is now; kOk when all is told.
PlanStatus WeightedMaps::tell(Variant& variant, const Interrupted& interrupted) {
  std::unique_lock<std::mutex> lock(map_mutex_);
  if (variant.version == version_) return PlanStatus::kOk;
  const std::uint64_t version = version_;
  const std::vector<LtrView> ltrs = ltrs_;
  const std::vector<SolidLandmark> landmarks = landmarks_;
  const std::map<int, std::shared_ptr<const LtrContent>> contents = contents_;
  // Telling takes long: neither who tells of the map nor other requests wait for it.
  lock.unlock();
  variant.graph.reset();
  variant.map.setLtrs(ltrs);
  variant.map.setLandmarks(landmarks);
  std::size_t told = 0;
  for (const auto& [ltr, content] : contents) {
    std::shared_ptr<const LtrContent>& known = variant.contents[ltr];
    if (known == content) continue;
    variant.map.setContent(ltr, *content);
    known = content;
    const bool asks = interrupted && ++told % kContentsAtOnce == 0;
    const PlanStatus status = asks ? interrupted() : PlanStatus::kOk;
    if (status != PlanStatus::kOk) return status;
  }
  variant.contents = contents;
  variant.version = version;
  return PlanStatus::kOk;
}

PlanStatus WeightedMaps::prepare(Variant& variant, const Eigen::Vector2d& place,
                                 const Interrupted& interrupted) {
  const PlanStatus told = tell(variant, interrupted);
  if (told != PlanStatus::kOk || variant.graph) return told;
  PlanStatus status = PlanStatus::kOk;
  variant.map.prepare(place, kAllMatrices, [&] {
    if (interrupted) status = interrupted();
    return status != PlanStatus::kOk;
  });
  if (status == PlanStatus::kOk) variant.graph = variant.map.makeGraph();
  return status;
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
  const std::shared_ptr<Variant> taken = take(weights, interrupted, refused);
  if (!taken) return nullptr;
  // Given back however this ends.
  const std::unique_ptr<Variant, std::function<void(Variant*)>> variant(
      taken.get(), [this](Variant* of) { giveBack(*of); });
  const PlanStatus status = prepare(*variant, place, interrupted);
  if (status == PlanStatus::kOk) return variant->graph;
  refused = unprepared(status);
  return nullptr;
}

}  // namespace hymm::core
