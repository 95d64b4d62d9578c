#include <string_view>

#include "cekf/cekf_slam.h"
#include "common/error.h"
#include "fuzz/harness.h"
#include "hybrid_map/hybrid_map.h"

namespace hymm::test {
namespace {

using namespace core;

ObservationSet threeTrunks(double time_s) {
  ObservationSet set;
  set.time_s = time_s;
  for (const double bearing : {0.4, -0.5, 1.2}) {
    Observation observation;
    observation.range_m = 8.0;
    observation.bearing_rad = bearing;
    observation.covariance = Eigen::Vector2d(1e-3, 1e-5).asDiagonal();
    set.observations.push_back(observation);
  }
  return set;
}

bool isFilter(std::string_view state) {
  try {
    CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
    slam.loadState(state, "state", MapUse::kExtend);
    slam.process(MotionInput{AckermannInput{1.0, 1.0, 0.0}});
    slam.landmarkMap(30.0);
    slam.saveState();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

bool isDenseMap(std::string_view state) {
  try {
    HybridMap map(HybridMapConfig{});
    map.loadState(state, "state", 1);
    map.saveState();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

/// The state of either owner of a map, behind all checksums.
bool isRead(const std::uint8_t* data, std::size_t size) {
  const std::string_view state(reinterpret_cast<const char*>(data), size);
  const bool is_filter = isFilter(state);
  const bool is_dense_map = isDenseMap(state);
  return is_filter || is_dense_map;
}

/// Without a global update, which takes a tile of 128 KB.
std::map<std::string, std::string> seeds() {
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  std::map<std::string, std::string> states{{"new_filter", slam.saveState()},
                                            {"new_map", HybridMap(HybridMapConfig{}).saveState()}};
  for (int i = 0; i < 5; ++i) slam.process(threeTrunks(0.5 * i + 0.1));
  states["filter"] = slam.saveState();
  return states;
}

}  // namespace hymm::test
