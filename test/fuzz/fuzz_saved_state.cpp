#include <string>

#include "cekf/cekf_slam.h"
#include "common/error.h"
#include "hybrid_map/hybrid_map.h"
#include "input_file.h"

/// Something to begin with: without a global update, which takes a tile of 128 KB.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  using namespace hymm::core;
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  hymm::test::writeSeed("new_filter", slam.saveState());
  hymm::test::writeSeed("new_map", HybridMap(HybridMapConfig{}).saveState());
  for (int i = 0; i < 5; ++i) {
    ObservationSet set;
    set.time_s = 0.5 * i + 0.1;
    for (const double bearing : {0.4, -0.5, 1.2}) {
      Observation observation;
      observation.range_m = 8.0;
      observation.bearing_rad = bearing;
      observation.covariance = Eigen::Vector2d(1e-3, 1e-5).asDiagonal();
      set.observations.push_back(observation);
    }
    slam.process(set);
  }
  hymm::test::writeSeed("filter", slam.saveState());
  return 0;
}

/// The state of either owner of a map, behind all checksums: restored, or refused with an
/// InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hymm::core;
  const std::string_view state(reinterpret_cast<const char*>(data), size);
  try {
    CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
    slam.loadState(state, "state", MapUse::kExtend);
    slam.process(MotionInput{AckermannInput{1.0, 1.0, 0.0}});
    slam.landmarkMap(30.0);
    slam.saveState();
  } catch (const InputError&) {
  }
  try {
    HybridMap map(HybridMapConfig{});
    map.loadState(state, "state", 1);
    map.saveState();
  } catch (const InputError&) {
  }
  return 0;
}
