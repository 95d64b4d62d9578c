#include "ros/transform_lookup.h"

#include <stdexcept>

namespace hymm {

std::string withoutSlash(const std::string& name) {
  return name.empty() || name.front() != '/' ? name : name.substr(1);
}

TransformAnswer findTransform(const tf2::BufferCore& tf, const std::string& target,
                              const std::string& source, const ros::Time& stamp) {
  try {
    return {tf.lookupTransform(target, source, stamp), ""};
  } catch (const std::runtime_error& error) {  // tf2::TransformException, and of ros::Duration
    return {std::nullopt, error.what()};
  }
}

}  // namespace hymm
