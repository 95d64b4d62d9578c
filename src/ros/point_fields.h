#pragma once

#include <cstdint>
#include <string>

#include <sensor_msgs/PointCloud2.h>

namespace hymm {

/// The field of that name; null if there is none.
const sensor_msgs::PointField* findField(const sensor_msgs::PointCloud2& cloud,
                                         const std::string& name);

/// Whether a field is one number of a kind that NumberField reads: FLOAT32, FLOAT64, INT32, UINT32.
bool isReadable(const sensor_msgs::PointField& field);

/// Whether it lies within a point.
bool isInside(const sensor_msgs::PointField& field, const sensor_msgs::PointCloud2& cloud);

/// One number of the points of a cloud, whose field isReadable() and isInside().
class NumberField {
 public:
  NumberField(const sensor_msgs::PointCloud2& cloud, const sensor_msgs::PointField& field)
      : offset_(field.offset), datatype_(field.datatype), swaps_(cloud.is_bigendian != 0U) {}

  double of(const std::uint8_t* point) const;

 private:
  std::size_t offset_;
  std::uint8_t datatype_;
  bool swaps_;
};

}  // namespace hymm
