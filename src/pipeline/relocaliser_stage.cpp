#include "pipeline/relocaliser_stage.h"

#include <future>
#include <memory>

#include "common/cpu_timer.h"

namespace hymm::core {

RelocaliserStage::RelocaliserStage(const RelocaliserConfig& config, const VehicleConfig& vehicle)
    : relocalisation_(config, vehicle, link_) {}

void RelocaliserStage::takeEvent(const SensorEvent& event) {
  const auto* input = std::get_if<MotionInput>(&event);
  if (input == nullptr) return;
  const CpuTimer timer(cpu_s_);
  relocalisation_.take(*input);
}

void RelocaliserStage::takeScan(const ScanStep& step, CekfSlam& filter) {
  const CpuTimer timer(cpu_s_);
  link_.filter = &filter;
  ObservationSet observations = step.outcome.observations;
  observations.T_base_sensor = step.outcome.pose.T_base_sensor;
  relocalisation_.take(observations, step.outcome.pose);
  workOff();
}

void RelocaliserStage::begin(const SearchOrder& order, CekfSlam& filter) {
  const CpuTimer timer(cpu_s_);
  link_.filter = &filter;
  relocalisation_.begin(order);
  workOff();
}

/// Here nothing is gained by doing it later.
void RelocaliserStage::workOff() {
  while (relocalisation_.work()) {
  }
}

void RelocaliserStage::reset(double) { relocalisation_.reset(); }

void RelocaliserStage::addTo(RunTotals& totals) const { totals.subsystem_cpu_s[kName] = cpu_s_; }

std::map<std::string, std::size_t> RelocaliserStage::incidents() const {
  std::map<std::string, std::size_t> incidents;
  if (relocalisation_.searches() > 0) {
    incidents["searches of the relocaliser"] = static_cast<std::size_t>(relocalisation_.searches());
  }
  return incidents;
}

std::vector<LandmarkEstimate> RelocaliserStage::EngineLink::landmarks() {
  return filter->landmarkMap(0.0).landmarks;
}

std::string RelocaliserStage::EngineLink::suspend(double time_T0_s) {
  return filter->suspend(time_T0_s) ? ""
                                    : "The filter cannot go back to the last scan in good "
                                      "order: that is too long ago (local_states_s).";
}

std::optional<FilterKnowledge> RelocaliserStage::EngineLink::ask(const std::vector<int>& ids,
                                                                 std::string& problem) {
  const auto promise = std::make_shared<std::promise<VehicleAmongLandmarks>>();
  std::future<VehicleAmongLandmarks> answer = promise->get_future();
  const bool is_asked = filter->requestVehicleAmongLandmarks(
      ids, [promise](VehicleAmongLandmarks estimate) { promise->set_value(std::move(estimate)); });
  if (!is_asked) {
    problem = "A landmark near the vehicle is in the map no more.";
    return std::nullopt;
  }
  return FilterKnowledge{answer.get(), filter->calibration()};
}

FilterLink::ResumeAnswer RelocaliserStage::EngineLink::resume(double time_T0_s,
                                                              const std::vector<PlaceAtScan>& path,
                                                              bool elsewhere) {
  const Resumption resumption =
      elsewhere ? filter->resumeElsewhere(time_T0_s, path) : filter->resume(time_T0_s, path);
  return {resumption.accepted(), resumption.reason};
}

}  // namespace hymm::core
