#include "ros/grid_conversions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ros/time_conversions.h"

namespace hymm {
namespace {

/// A grid that reaches farther from the map's origin, in cells, is none of a vehicle.
constexpr double kMostCells = 1e9;

Ltr toMessage(const core::LtrTopology& ltr) {
  Ltr message;
  message.id = ltr.id;
  for (std::size_t i = 0; i < 3; ++i) {
    message.landmark_ids[i] = ltr.landmark_ids[i];
    message.neighbours[i] = ltr.neighbours[i];
  }
  message.alpha_cells = static_cast<std::uint32_t>(ltr.alpha_cells);
  message.beta_cells = static_cast<std::uint32_t>(ltr.beta_cells);
  message.observations = ltr.observations;
  message.shape_factor = ltr.shape_factor;
  return message;
}

}  // namespace

LtrMap toMessage(const std::vector<core::LtrTopology>& ltrs, std::uint64_t landmark_version) {
  LtrMap message;
  message.landmark_version = landmark_version;
  for (const core::LtrTopology& ltr : ltrs) message.ltrs.push_back(toMessage(ltr));
  return message;
}

std::vector<core::LtrTopology> fromMessage(const LtrMap& message) {
  std::vector<core::LtrTopology> ltrs;
  for (const Ltr& told : message.ltrs) {
    core::LtrTopology ltr;
    ltr.id = told.id;
    for (std::size_t i = 0; i < 3; ++i) {
      ltr.landmark_ids[i] = told.landmark_ids[i];
      ltr.neighbours[i] = told.neighbours[i];
    }
    ltr.alpha_cells = static_cast<int>(told.alpha_cells);
    ltr.beta_cells = static_cast<int>(told.beta_cells);
    ltr.observations = told.observations;
    ltr.shape_factor = told.shape_factor;
    ltrs.push_back(ltr);
  }
  return ltrs;
}

LtrGrid toMessage(const core::HybridMap& map, const core::ChangedLayer& changed) {
  const core::LtrCells& cells = *map.cells(changed.ltr);
  LtrGrid message;
  message.ltr = changed.ltr;
  message.layer = map.layers().name(changed.layer);
  message.model = map.layers().modelText(changed.layer);
  message.alpha_cells = static_cast<std::uint32_t>(cells.grid.alphaCells());
  message.beta_cells = static_cast<std::uint32_t>(cells.grid.betaCells());
  message.channels = static_cast<std::uint32_t>(map.layers().channels(changed.layer));
  message.revision = changed.revision;
  std::vector<float> buffer;  // what is packed stays packed
  message.cells = cells.store.peek(changed.layer, buffer);
  return message;
}

nav_msgs::OccupancyGrid toMessage(const core::OccupancyImage& image) {
  nav_msgs::OccupancyGrid message;
  message.info.resolution = static_cast<float>(image.resolution_m);
  message.info.width = static_cast<std::uint32_t>(image.width);
  message.info.height = static_cast<std::uint32_t>(image.height);
  message.info.origin.position.x = image.origin().x();
  message.info.origin.position.y = image.origin().y();
  message.info.origin.orientation.w = 1.0;
  message.data = image.cells;
  return message;
}

map_msgs::OccupancyGridUpdate toMessage(const core::OccupancyImage& image,
                                        const core::ImagePatch& patch) {
  map_msgs::OccupancyGridUpdate message;
  message.x = patch.x;
  message.y = patch.y;
  message.width = static_cast<std::uint32_t>(patch.width);
  message.height = static_cast<std::uint32_t>(patch.height);
  message.data = core::cutOut(image, patch);
  return message;
}

std::string problemOf(const nav_msgs::OccupancyGrid& grid) {
  const auto resolution_m = static_cast<double>(grid.info.resolution);
  const auto& origin = grid.info.origin;
  if (!(resolution_m > 1e-3) || !std::isfinite(resolution_m)) {
    return "its resolution is " + std::to_string(resolution_m) + " m";
  }
  if (grid.data.size() != std::size_t{grid.info.width} * grid.info.height) {
    return "it has " + std::to_string(grid.data.size()) + " cells, not " +
           std::to_string(grid.info.width) + " x " + std::to_string(grid.info.height);
  }
  const double longest = std::max(grid.info.width, grid.info.height);  // even without any cell
  const double far_m =
      std::abs(origin.position.x) + std::abs(origin.position.y) + resolution_m * longest;
  if (!(far_m / resolution_m < kMostCells)) return "it reaches too far";
  if (std::abs(origin.orientation.x) + std::abs(origin.orientation.y) +
          std::abs(origin.orientation.z) >
      1e-6) {
    return "it is turned; only maps along the axes of their frame can be used";
  }
  return {};
}

core::OccupancyImage fromMessage(const nav_msgs::OccupancyGrid& message) {
  core::OccupancyImage image;
  // The float of the message stands for a short decimal, as 0.2.
  image.resolution_m = std::round(1e6 * static_cast<double>(message.info.resolution)) / 1e6;
  const auto& origin = message.info.origin.position;
  if (image.resolution_m > 0.0) {
    image.corner = {static_cast<int>(std::lround(origin.x / image.resolution_m)),
                    static_cast<int>(std::lround(origin.y / image.resolution_m))};
  }
  image.width = static_cast<int>(message.info.width);
  image.height = static_cast<int>(message.info.height);
  image.cells = message.data;
  return image;
}

bool applyUpdate(const map_msgs::OccupancyGridUpdate& update, core::OccupancyImage& image) {
  // In 64 bits: place and size of a message may add up to more than an int holds.
  const bool fits = update.x >= 0 && update.y >= 0 &&
                    std::int64_t{update.x} + update.width <= image.width &&
                    std::int64_t{update.y} + update.height <= image.height &&
                    update.data.size() == std::size_t{update.width} * update.height;
  if (!fits) return false;
  const auto width = static_cast<int>(update.width), height = static_cast<int>(update.height);
  for (int y = 0; y < height; ++y) {
    const auto row = update.data.begin() + std::ptrdiff_t{y} * width;
    std::copy(
        row, row + width,
        image.cells.begin() + static_cast<std::ptrdiff_t>(image.index(update.x, update.y + y)));
  }
  return true;
}

void fillMemory(const core::GridMemory& memory, GridStatus& status) {
  status.ltrs = static_cast<std::uint32_t>(memory.ltrs);
  status.unpacked_bytes = memory.in_ltrs.unpacked_bytes;
  status.packed_bytes = memory.in_ltrs.packed_bytes;
  status.packed_from_bytes = memory.in_ltrs.packed_from_bytes;
  status.waiting_bytes = memory.waiting_bytes;
}

core::GridMemory memoryOf(const GridStatus& status) {
  core::GridMemory memory;
  memory.time_s = status.header.stamp.toSec();
  memory.ltrs = status.ltrs;
  memory.in_ltrs.unpacked_bytes = status.unpacked_bytes;
  memory.in_ltrs.packed_bytes = status.packed_bytes;
  memory.in_ltrs.packed_from_bytes = status.packed_from_bytes;
  memory.waiting_bytes = status.waiting_bytes;
  return memory;
}

core::PropertySample fromMessage(const PropertySample& message, const core::Pose2& T_map_frame) {
  core::PropertySample sample;
  sample.layer = message.layer;
  sample.position = T_map_frame * Eigen::Vector2d(message.position.x, message.position.y);
  Eigen::Matrix2d covariance;
  covariance << message.position_covariance[0], message.position_covariance[1],
      message.position_covariance[2], message.position_covariance[3];
  const Eigen::Matrix2d R = T_map_frame.rotation();
  sample.covariance = R * covariance * R.transpose();
  sample.sample.time_s = message.header.stamp.toSec();
  sample.sample.value = message.value;
  sample.sample.variance = message.variance;
  sample.sample.exposure_s = message.exposure;
  sample.sample.label = message.label;
  return sample;
}

}  // namespace hymm
