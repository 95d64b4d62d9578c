#include "pipeline/grid_stage.h"

#include "common/unfinished_file.h"
#include "hybrid_map/map_export.h"

namespace hymm::core {

void GridStage::takeScan(const ScanStep& step, CekfSlam& filter) {
  MappedScan mapped;
  mapped.pose = step.outcome.pose;
  mapped.update = step.update;
  mapped.map = step.map;
  const auto* scan = std::get_if<ScanEvent>(&step.event);
  if (scan != nullptr && !step.outcome.suspended) mapped.scan = scan->scan;
  const MappedOutcome outcome = mapper_.process(mapped);
  agreement_ = outcome.agreement;
  writeSamples(step.outcome);
  const double time_s = step.outcome.pose.time_s;
  if (outcome.topology) filter.pinLandmarks(time_s, mapper_.map().pinnedLandmarks());
  if (memory_due_.takeIfDue(time_s)) memory_log_.add(memoryOf(mapper_.map(), time_s));
}

void GridStage::writeSamples(const ScanOutcome& outcome) {
  if (outcome.suspended) {
    samples_.forgetPoses();
    return;
  }
  const StampedPose pose{outcome.pose.time_s, outcome.pose.T_map_base};
  for (const PropertySample& sample : samples_.takePlaced(pose)) {
    const MapOutcome written = mapper_.insert(sample);
    if (written.accepted) continue;
    Refusal& refusal =
        refused_samples_.try_emplace(sample.layer, Refusal{written.reason, 0}).first->second;
    ++refusal.count;
  }
}

void GridStage::reset(double) {
  mapper_.reset();
  samples_.reset();
}

void GridStage::addTo(RunTotals& totals) const {
  totals.subsystem_cpu_s[kName] = mapper_.cpu_s();
  totals.ltrs = mapper_.topology().size();
}

std::map<std::string, std::size_t> GridStage::incidents() const {
  std::map<std::string, std::size_t> incidents;
  for (const auto& [layer, refusal] : refused_samples_) {
    incidents["property samples for layer '" + layer + "' refused, the first because " +
              refusal.first_reason] = refusal.count;
  }
  const auto add = [&](const char* what, std::size_t count) {
    if (count > 0) incidents[what] = count;
  };
  const HybridMap::Counts& map = mapper_.map().counts();
  add("scans not written into the map: the pose is not certain enough relative to the landmarks",
      mapper_.counts().not_written);
  add("property samples of times at which the vehicle's pose is not known",
      samples_.withoutPlace());
  add("landmark maps or updates that the dense map refused", map.refused_landmarks);
  add("tiles of observations outside of every LTR dropped for want of memory",
      map.dropped_waiting_tiles);
  add("LTRs far from the vehicle emptied for want of memory (max_memory_mb)", map.forgotten_ltrs);
  return incidents;
}

void GridStage::write(const std::filesystem::path& folder) {
  replaceFile(folder / "ltrs.csv", ltrsText(mapper_.topology()));
  replaceFile(folder / "map_memory.csv", memory_log_.text());
  image_.update(mapper_.map());
  if (!image_.image().cells.empty()) exportPgm(image_.image(), folder / "map");
}

}  // namespace hymm::core
