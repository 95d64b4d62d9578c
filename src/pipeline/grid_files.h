#pragma once

#include <string>
#include <vector>

#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/ltr_topology.h"

namespace hymm::core {

/// Memory of a map at one time.
struct GridMemory {
  double time_s = 0.0;
  std::size_t ltrs = 0;
  CellMemory in_ltrs;
  std::size_t waiting_bytes = 0;  ///< of what lies outside of every LTR
};

/// How often, by stamps, map_memory.csv has a line.
constexpr double kMemoryLogPeriod_s = 10.0;

/// The content of map_memory.csv: how much memory the map took in the course of a run.
class MapMemoryLog {
 public:
  void add(const GridMemory& memory);
  const std::string& text() const { return text_; }

 private:
  std::string text_ = "t,ltrs,unpacked_mb,packed_mb,packed_from_mb,waiting_mb\n";
};

/// The content of ltrs.csv.
std::string ltrsText(const std::vector<LtrTopology>& ltrs);

GridMemory memoryOf(const HybridMap& map, double time_s);

}  // namespace hymm::core
