#include "ros/point_fields.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace hymm {
namespace {

using sensor_msgs::PointField;

std::size_t sizeOf(std::uint8_t datatype) {
  return datatype == PointField::FLOAT64 ? sizeof(double) : sizeof(float);
}

template <class Number>
double read(const std::uint8_t* bytes) {
  Number value{};
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<double>(value);
}

}  // namespace

const PointField* findField(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  const auto field = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                  [&](const auto& candidate) { return candidate.name == name; });
  return field == cloud.fields.end() ? nullptr : &*field;
}

bool isReadable(const PointField& field) {
  const auto type = field.datatype;
  return field.count <= 1U && (type == PointField::FLOAT32 || type == PointField::FLOAT64 ||
                               type == PointField::INT32 || type == PointField::UINT32);
}

bool isInside(const PointField& field, const sensor_msgs::PointCloud2& cloud) {
  return std::size_t{field.offset} + sizeOf(field.datatype) <= cloud.point_step;
}

double NumberField::of(const std::uint8_t* point) const {
  const std::size_t size = sizeOf(datatype_);
  std::array<std::uint8_t, sizeof(double)> bytes{};
  std::copy_n(point + offset_, size, bytes.begin());
  if (swaps_) std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  switch (datatype_) {
    case PointField::FLOAT64:
      return read<double>(bytes.data());
    case PointField::INT32:
      return read<std::int32_t>(bytes.data());
    case PointField::UINT32:
      return read<std::uint32_t>(bytes.data());
    default:
      return read<float>(bytes.data());
  }
}

}  // namespace hymm
