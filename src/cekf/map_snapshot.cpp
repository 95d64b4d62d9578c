#include "cekf/map_snapshot.h"

#include <algorithm>

#include "cekf/landmark_index.h"

namespace hymm::core {
namespace {

LandmarkEstimate withoutPlace(const RegisteredLandmark& landmark) {
  LandmarkEstimate estimate;
  estimate.id = landmark.id;
  estimate.type = landmark.type;
  estimate.diameter_m = landmark.diameter_m;
  estimate.diameter_variance = landmark.diameter_variance;
  estimate.observations = landmark.observations;
  estimate.last_seen_s = landmark.last_seen_s;
  estimate.first_seen_s = landmark.first_seen_s;
  return estimate;
}

}  // namespace

LandmarkEstimate estimateOf(const RegisteredLandmark& landmark, const CompressedEkf& filter) {
  LandmarkEstimate estimate = withoutPlace(landmark);
  estimate.position = filter.landmark(landmark.slot);
  estimate.covariance = filter.covariance(landmark.slot, landmark.slot);
  return estimate;
}

LandmarkMap snapshotOf(std::vector<RegisteredLandmark> landmarks, const EffectReader& reader,
                       double block_range_m) {
  std::sort(landmarks.begin(), landmarks.end(),
            [](const auto& a, const auto& b) { return a.id < b.id; });
  LandmarkMap map;
  LandmarkIndex index;  // by place in `landmarks`, which is in the order of ids
  for (const RegisteredLandmark& landmark : landmarks) {
    const int state = CompressedEkf::storeIndex(landmark.slot);
    LandmarkEstimate estimate = withoutPlace(landmark);
    estimate.position = reader.state(state);
    estimate.covariance = reader.covariance(state, state);
    index.place(static_cast<int>(map.landmarks.size()), estimate.position);
    map.landmarks.push_back(estimate);
  }
  if (block_range_m <= 0.0) return map;
  for (std::size_t a = 0; a < landmarks.size(); ++a) {
    const Eigen::Vector2d& position = map.landmarks[a].position;
    for (const int near : index.near(position, block_range_m)) {
      const auto b = static_cast<std::size_t>(near);
      if (b <= a || (map.landmarks[b].position - position).norm() > block_range_m) continue;
      map.cross_covariances.push_back(
          {landmarks[a].id, landmarks[b].id,
           reader.covariance(CompressedEkf::storeIndex(landmarks[a].slot),
                             CompressedEkf::storeIndex(landmarks[b].slot))});
    }
  }
  return map;
}

}  // namespace hymm::core
