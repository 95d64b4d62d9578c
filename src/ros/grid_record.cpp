#include "ros/grid_record.h"

#include <string>

#include "common/unfinished_file.h"
#include "hybrid_map/map_export.h"
#include "ros/grid_conversions.h"

namespace hymm {

void GridRecord::subscribe(ros::NodeHandle& handle) {
  constexpr std::uint32_t kUnbounded = 0;  // a record with holes would be worthless
  const auto hints = ros::TransportHints().tcpNoDelay();
  subscribers_ = {
      handle.subscribe("ltrs", 10, &GridRecord::takeLtrs, this, hints),
      handle.subscribe("map", kUnbounded, &GridRecord::takeMap, this, hints),
      handle.subscribe("map_updates", kUnbounded, &GridRecord::takeMapUpdate, this, hints),
      handle.subscribe("grid_status", kUnbounded, &GridRecord::takeStatus, this, hints)};
}

void GridRecord::takeMap(const nav_msgs::OccupancyGrid& message) {
  if (const std::string problem = problemOf(message); !problem.empty()) {
    causes_.count("dense maps refused", "A dense map on `map` is not recorded: " + problem + ".");
    return;
  }
  image_ = fromMessage(message);
}

void GridRecord::takeMapUpdate(const map_msgs::OccupancyGridUpdate& message) {
  if (image_) applyUpdate(message, *image_);
}

void GridRecord::takeStatus(const GridStatus& message) {
  status_ = message;
  if (message.for_log) memory_log_.add(memoryOf(message));
}

void GridRecord::addTo(core::RunTotals& totals) const {
  if (!status_) return;
  totals.subsystem_cpu_s["hymm_grid"] = status_->cpu_s;
  totals.cpu_s += status_->cpu_s;
  if (ltrs_) totals.ltrs = ltrs_->ltrs.size();
}

void GridRecord::write() const {
  if (!status_) return;
  core::replaceFile(folder_ / "map_memory.csv", memory_log_.text());
  if (ltrs_) core::replaceFile(folder_ / "ltrs.csv", core::ltrsText(fromMessage(*ltrs_)));
  if (image_ && !image_->cells.empty()) core::exportPgm(*image_, folder_ / "map");
}

}  // namespace hymm
