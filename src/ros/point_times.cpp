#include "ros/point_times.h"

#include <cmath>
#include <optional>
#include <sstream>

#include "ros/point_fields.h"

namespace hymm {
namespace {

using sensor_msgs::PointField;

constexpr double kNano = 1e-9;

const PointField* timeField(const sensor_msgs::PointCloud2& cloud) {
  for (const char* name : {"time", "t", "timestamp", "offset_time"}) {
    if (const PointField* field = findField(cloud, name)) return field;
  }
  return nullptr;
}

/// What a field's number means: seconds after the stamp = scale * number - zero_s.
struct Meaning {
  double scale = 1.0;
  double zero_s = 0.0;

  double of(double number) const { return scale * number - zero_s; }
};

/// By a number of the field.
Meaning meaningOf(const PointField& field, double number, double stamp_s) {
  if (field.datatype == PointField::FLOAT32) return {};
  if (field.datatype != PointField::FLOAT64) return {kNano, 0.0};
  for (const Meaning& absolute : {Meaning{1.0, stamp_s}, Meaning{kNano, stamp_s}}) {
    if (std::abs(absolute.of(number)) <= PointTimes::kFarthest_s) return absolute;
  }
  return {};
}

std::vector<double> numbersOf(const sensor_msgs::PointCloud2& cloud, const PointField& field) {
  std::vector<double> numbers;
  numbers.reserve(std::size_t{cloud.width} * cloud.height);
  const NumberField number(cloud, field);
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* point = cloud.data.data() + row * cloud.row_step;
    for (std::size_t i = 0; i < cloud.width; ++i, point += cloud.point_step) {
      numbers.push_back(number.of(point));
    }
  }
  return numbers;
}

}  // namespace

PointTimes pointTimes(const sensor_msgs::PointCloud2& cloud,
                      const std::vector<Eigen::Vector3f>& points,
                      const core::PointCloudConfig& config) {
  const PointField* field = timeField(cloud);
  if (field == nullptr || points.empty()) return {};
  if (!isReadable(*field) || !isInside(*field, cloud)) {
    return {{}, "its field '" + field->name + "' is not one number within point_step"};
  }
  PointTimes times{numbersOf(cloud, *field), ""};
  std::optional<Meaning> meaning;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double& time = times.after_stamp_s[i];
    if (!core::isSeen(points[i], config)) {
      time = 0.0;
      continue;
    }
    if (!meaning) meaning = meaningOf(*field, time, cloud.header.stamp.toSec());
    const double after_s = meaning->of(time);
    if (!(std::abs(after_s) <= PointTimes::kFarthest_s)) {
      std::ostringstream problem;
      problem << "its field '" << field->name << "' says " << time << ", which is no time within "
              << PointTimes::kFarthest_s << " s of the stamp";
      return {{}, problem.str()};
    }
    time = after_s;
  }
  return times;
}

}  // namespace hymm
