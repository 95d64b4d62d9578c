#include "ros/map_conversions.h"

#include <boost/array.hpp>

#include "ros/sensor_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

using Block = boost::array<double, 4>;

Block toMessage(const Eigen::Matrix2d& matrix) {
  return {{matrix(0, 0), matrix(0, 1), matrix(1, 0), matrix(1, 1)}};
}

Eigen::Matrix2d fromMessage(const Block& block) {
  return (Eigen::Matrix2d() << block[0], block[1], block[2], block[3]).finished();
}

Landmark toMessage(const core::LandmarkEstimate& landmark) {
  Landmark message;
  message.id = landmark.id;
  message.type = static_cast<std::uint8_t>(landmark.type);
  message.position.x = landmark.position.x();
  message.position.y = landmark.position.y();
  message.covariance = toMessage(landmark.covariance);
  message.diameter = landmark.diameter_m;
  message.diameter_variance = landmark.diameter_variance;
  message.observations = static_cast<std::uint32_t>(landmark.observations);
  message.last_seen = toRosTime(landmark.last_seen_s);
  message.first_seen = toRosTime(landmark.first_seen_s);
  return message;
}

core::LandmarkEstimate fromMessage(const Landmark& message) {
  core::LandmarkEstimate landmark;
  landmark.id = message.id;
  landmark.type = landmarkType(message.type);
  landmark.position = {message.position.x, message.position.y};
  landmark.covariance = fromMessage(message.covariance);
  landmark.diameter_m = message.diameter;
  landmark.diameter_variance = message.diameter_variance;
  landmark.observations = static_cast<int>(message.observations);
  landmark.last_seen_s = message.last_seen.toSec();
  landmark.first_seen_s = message.first_seen.toSec();
  return landmark;
}

LandmarkMerge toMessage(const core::LandmarkMerge& merge) {
  LandmarkMerge message;
  message.id = merge.from_id;
  message.into_id = merge.into_id;
  return message;
}

core::LandmarkMerge fromMessage(const LandmarkMerge& message) {
  return {message.id, message.into_id};
}

LandmarkCovariance toMessage(const core::CrossCovariance& cross) {
  LandmarkCovariance message;
  message.first_id = cross.first_id;
  message.second_id = cross.second_id;
  message.covariance = toMessage(cross.block);
  return message;
}

core::CrossCovariance fromMessage(const LandmarkCovariance& message) {
  return {message.first_id, message.second_id, fromMessage(message.covariance)};
}

}  // namespace

LandmarkMap toMessage(const core::LandmarkMap& map, double block_range_m,
                      const std::string& frame_id) {
  LandmarkMap message;
  message.header.stamp = toRosTime(map.time_s);
  message.header.frame_id = frame_id;
  message.version = map.version;
  message.block_range = block_range_m;
  message.landmarks.reserve(map.landmarks.size());
  for (const auto& landmark : map.landmarks) message.landmarks.push_back(toMessage(landmark));
  for (const auto& merge : map.merges) message.merged_into.push_back(toMessage(merge));
  message.cross_covariances.reserve(map.cross_covariances.size());
  for (const auto& cross : map.cross_covariances) {
    message.cross_covariances.push_back(toMessage(cross));
  }
  return message;
}

core::LandmarkMap fromMessage(const LandmarkMap& message) {
  core::LandmarkMap map;
  map.time_s = message.header.stamp.toSec();
  map.version = message.version;
  map.landmarks.reserve(message.landmarks.size());
  for (const auto& landmark : message.landmarks) map.landmarks.push_back(fromMessage(landmark));
  for (const auto& merge : message.merged_into) map.merges.push_back(fromMessage(merge));
  map.cross_covariances.reserve(message.cross_covariances.size());
  for (const auto& cross : message.cross_covariances) {
    map.cross_covariances.push_back(fromMessage(cross));
  }
  return map;
}

LandmarkUpdate toMessage(const core::LandmarkUpdate& update, double time_s,
                         const std::string& frame_id) {
  LandmarkUpdate message;
  message.header.stamp = toRosTime(time_s);
  message.header.frame_id = frame_id;
  message.since_version = update.since_version;
  message.version = update.version;
  for (const auto& landmark : update.changed) message.changed.push_back(toMessage(landmark));
  message.removed_ids.assign(update.removed_ids.begin(), update.removed_ids.end());
  for (const auto& merge : update.merges) message.merged_into.push_back(toMessage(merge));
  return message;
}

core::LandmarkUpdate fromMessage(const LandmarkUpdate& message) {
  core::LandmarkUpdate update;
  update.since_version = message.since_version;
  update.version = message.version;
  for (const auto& landmark : message.changed) update.changed.push_back(fromMessage(landmark));
  update.removed_ids.assign(message.removed_ids.begin(), message.removed_ids.end());
  for (const auto& merge : message.merged_into) update.merges.push_back(fromMessage(merge));
  return update;
}

}  // namespace hymm
