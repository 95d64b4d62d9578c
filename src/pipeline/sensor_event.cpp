#include "pipeline/sensor_event.h"

namespace hymm::core {
namespace {

struct TimeVisitor {
  double operator()(const MotionInput& input) const { return timeOf(input); }
  double operator()(const ScanEvent& event) const { return event.scan.time_s; }
  double operator()(const ObservationSet& set) const { return set.time_s; }
  double operator()(const GpsFix& fix) const { return fix.time_s; }
  double operator()(const ClockReset& reset) const { return reset.time_s; }
};

}  // namespace

double timeOf(const SensorEvent& event) { return std::visit(TimeVisitor{}, event); }

double endOf(const SensorEvent& event) {
  if (const auto* input = std::get_if<MotionInput>(&event)) return endOf(*input);
  const auto* scan = std::get_if<ScanEvent>(&event);
  return timeOf(event) + (scan != nullptr ? scan->scan.sweep_s() : 0.0);
}

}  // namespace hymm::core
