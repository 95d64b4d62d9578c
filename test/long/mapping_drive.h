#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "benchmark/flat_grid.h"
#include "cekf/map_schedule.h"
#include "hybrid_map/log_odds.h"
#include "hybrid_map/map_export.h"
#include "hybrid_map/packed_floats.h"
#include "pipeline/grid_files.h"
#include "pipeline/grid_mapper.h"
#include "pipeline/suite_config.h"

namespace hymm::test {

/// The filter with the dense map behind it, as an offline run wires them, and beside it a plain
/// global grid that gets the same scans at the same estimated poses.
class MappingDrive {
 public:
  /// What became of a scan that the filter accepted.
  struct Step {
    core::ScanOutcome outcome;
    std::optional<core::PosedScan> written;
  };

  /// The plain grid covers the box from `low` to `high`.
  MappingDrive(const core::SuiteConfig& config, const Eigen::Vector2d& low,
               const Eigen::Vector2d& high)
      : config_(config),
        filter_(config.cekf_slam, config.vehicle),
        schedule_(config.cekf_slam),
        mapper_(config.hymm_grid),
        flat_(low, high, config.hymm_grid.map.resolution_m, config.hymm_grid.map.occupancy) {}

  std::optional<Step> process(const core::SensorEvent& event) {
    const auto outcome = filter_.process(event);
    const auto* scan = std::get_if<core::ScanEvent>(&event);
    if (!outcome || !outcome->accepted || scan == nullptr) return std::nullopt;
    return take(*scan, *outcome);
  }

  core::GridMapper& mapper() { return mapper_; }
  const core::GridMapper& mapper() const { return mapper_; }
  const core::CekfSlam& filter() const { return filter_; }
  const benchmarks::FlatGrid& flat() const { return flat_; }
  const std::string& memoryText() const { return memory_.text(); }

 private:
  Step take(const core::ScanEvent& scan, const core::ScanOutcome& outcome) {
    const double time_s = outcome.pose.time_s;
    core::MappedScan mapped;
    mapped.pose = outcome.pose;
    mapped.update = filter_.takeUpdate();
    mapped.scan = scan.scan;
    const bool corrected = filter_.counts().map_corrections > corrections_;
    corrections_ = filter_.counts().map_corrections;
    if (schedule_.isDue(time_s, corrected)) {
      schedule_.note(time_s);
      mapped.map = std::make_shared<const core::LandmarkMap>(
          filter_.landmarkMap(config_.cekf_slam.landmark_block_range_m));
    }
    const core::MappedOutcome mapping = mapper_.process(mapped);
    if (mapping.topology) filter_.pinLandmarks(time_s, mapper_.map().pinnedLandmarks());
    if (memory_due_.takeIfDue(time_s)) memory_.add(core::memoryOf(mapper_.map(), time_s));
    Step step{outcome, std::nullopt};
    if (!mapping.written) return step;
    step.written = mapper_.posed(scan.scan, outcome.pose);
    flat_.insert(step.written->scan, step.written->T_map_laser);
    return step;
  }

  core::SuiteConfig config_;
  core::CekfSlam filter_;
  core::MapSchedule schedule_;
  core::GridMapper mapper_;
  benchmarks::FlatGrid flat_;
  core::MapMemoryLog memory_;
  core::StampSchedule memory_due_{core::kMemoryLogPeriod_s};
  std::size_t corrections_ = 0;
};

/// What the occupancy of all LTRs takes in each form of compression, and what the lossy one does to
/// the cells that were ever seen.
struct CompressionFigures {
  double raw_mb = 0.0, lossless_mb = 0.0, lossy_mb = 0.0;
  double probability_rms = 0.0;         ///< of a cell's error
  double changed_share = 0.0;           ///< of cells that map_server would take for another kind
  double changed_occupied_share = 0.0;  ///< of the occupied ones among these
};

inline CompressionFigures compressionOf(const core::HybridMap& map, double occupied_probability) {
  constexpr int kOccupancy = core::LayerSet::kOccupancy;
  const auto threshold = static_cast<float>(core::logOddsOf(occupied_probability));
  const auto kindOf = [](float log_odds) {
    return core::trinaryOccupancy(core::occupancyPercent(log_odds));
  };
  CompressionFigures figures;
  double seen = 0.0, occupied = 0.0;
  std::vector<float> buffer;
  for (int ltr = 0; ltr < map.partition().mesh().ltrEnd(); ++ltr) {
    const core::LtrCells* cells = map.cells(ltr);
    if (cells == nullptr || cells->store.isEmpty(kOccupancy)) continue;
    const std::vector<float>& exact = cells->store.peek(kOccupancy, buffer);
    const core::OccupancyQuadtree tree(cells->grid, exact, threshold);
    const std::vector<float> lossy = tree.unpack();
    figures.raw_mb += 4e-6 * static_cast<double>(exact.size());
    figures.lossless_mb += 1e-6 * static_cast<double>(core::PackedFloats(exact).bytes());
    figures.lossy_mb += 1e-6 * static_cast<double>(tree.bytes());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      if (exact[i] == 0.0F) continue;
      const double error = core::probabilityOf(static_cast<double>(lossy[i])) -
                           core::probabilityOf(static_cast<double>(exact[i]));
      const bool is_occupied = kindOf(exact[i]) > 0, changed = kindOf(lossy[i]) != kindOf(exact[i]);
      seen += 1.0;
      occupied += is_occupied ? 1.0 : 0.0;
      figures.probability_rms += error * error;
      figures.changed_share += changed ? 1.0 : 0.0;
      figures.changed_occupied_share += changed && is_occupied ? 1.0 : 0.0;
    }
  }
  figures.probability_rms = std::sqrt(figures.probability_rms / std::max(1.0, seen));
  figures.changed_share /= std::max(1.0, seen);
  figures.changed_occupied_share /= std::max(1.0, occupied);
  return figures;
}

}  // namespace hymm::test
