#include "cekf/landmark_requests.h"

#include <utility>
#include <vector>

#include "cekf/map_snapshot.h"

namespace hymm::core {
namespace {

void fillJoint(const std::vector<int>& slots, const EffectReader& reader, JointLandmarks& joint) {
  const auto n = static_cast<Eigen::Index>(2 * slots.size());
  joint.mean.resize(n);
  joint.covariance.resize(n, n);
  for (Eigen::Index a = 0; a < n; a += 2) {
    const int index_a = CompressedEkf::storeIndex(slots[static_cast<std::size_t>(a / 2)]);
    joint.mean.segment<2>(a) = reader.state(index_a);
    for (Eigen::Index b = 0; b < n; b += 2) {
      joint.covariance.block<2, 2>(a, b) = reader.covariance(
          index_a, CompressedEkf::storeIndex(slots[static_cast<std::size_t>(b / 2)]));
    }
  }
}

}  // namespace

void requestMap(const LandmarkRegistry& registry, LandmarkMap header, double block_range_m,
                CompressedEkf& filter, std::function<void(LandmarkMap)> take) {
  std::vector<RegisteredLandmark> landmarks = registry.all();
  std::vector<int> slots;
  for (const RegisteredLandmark& landmark : landmarks) slots.push_back(landmark.slot);
  filter.readLater(slots,
                   [block_range_m, landmarks = std::move(landmarks), header = std::move(header),
                    take = std::move(take)](const EffectReader& reader) {
                     LandmarkMap map = snapshotOf(landmarks, reader, block_range_m);
                     map.version = header.version;
                     map.time_s = header.time_s;
                     map.merges = header.merges;
                     take(std::move(map));
                   });
}

bool requestJointLandmarks(const LandmarkRegistry& registry, JointLandmarks header,
                           CompressedEkf& filter, std::function<void(JointLandmarks)> take) {
  std::vector<int> slots;
  for (const int id : header.ids) {
    if (!registry.contains(id)) return false;
    slots.push_back(registry.byId(id).slot);
  }
  filter.readLater(slots, [slots, header = std::move(header),
                           take = std::move(take)](const EffectReader& reader) {
    JointLandmarks joint = header;
    fillJoint(slots, reader, joint);
    take(std::move(joint));
  });
  return true;
}

bool requestVehicleAmongLandmarks(const LandmarkRegistry& registry, VehicleAmongLandmarks header,
                                  CompressedEkf& filter,
                                  std::function<void(VehicleAmongLandmarks)> take) {
  header.cross_covariance.resize(3, 2 * static_cast<Eigen::Index>(header.landmarks.ids.size()));
  Eigen::Index column = 0;
  for (const int id : header.landmarks.ids) {
    if (!registry.contains(id)) return false;
    header.cross_covariance.middleCols<2>(column) =
        filter.vehicleLandmarkCovariance(registry.byId(id).slot).topRows<3>();
    column += 2;
  }
  JointLandmarks joint = std::move(header.landmarks);
  return requestJointLandmarks(
      registry, std::move(joint), filter,
      [header = std::move(header), take = std::move(take)](JointLandmarks landmarks) {
        VehicleAmongLandmarks estimate = header;
        estimate.landmarks = std::move(landmarks);
        take(std::move(estimate));
      });
}

}  // namespace hymm::core
