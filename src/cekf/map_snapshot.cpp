#include "cekf/map_snapshot.h"

namespace hymm::core {

LandmarkEstimate estimateOf(const RegisteredLandmark& landmark, const CompressedEkf& filter) {
  LandmarkEstimate estimate;
  estimate.id = landmark.id;
  estimate.type = landmark.type;
  estimate.position = filter.landmark(landmark.slot);
  estimate.covariance = filter.covariance(landmark.slot, landmark.slot);
  estimate.diameter_m = landmark.diameter_m;
  estimate.diameter_variance = landmark.diameter_variance;
  estimate.observations = landmark.observations;
  estimate.last_seen_s = landmark.last_seen_s;
  return estimate;
}

LandmarkMap snapshotOf(const LandmarkRegistry& registry, const CompressedEkf& filter,
                       double block_range_m) {
  LandmarkMap map;
  for (const int id : registry.ids()) {
    const RegisteredLandmark& landmark = registry.byId(id);
    map.landmarks.push_back(estimateOf(landmark, filter));
    if (block_range_m <= 0.0) continue;
    for (const int slot : registry.slotsNear(landmark.position, block_range_m)) {
      const int other_id = registry.bySlot(slot).id;
      if (other_id <= id) continue;
      map.cross_covariances.push_back({id, other_id, filter.covariance(landmark.slot, slot)});
    }
  }
  return map;
}

}  // namespace hymm::core
