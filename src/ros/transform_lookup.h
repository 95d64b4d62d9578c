#pragma once

#include <optional>
#include <string>

#include <geometry_msgs/TransformStamped.h>
#include <tf2/buffer_core.h>

namespace hymm {

/// A name as tf2 has it, without the leading slash that messages of old recordings have. Topics
/// have it or not in the same way.
std::string withoutSlash(const std::string& name);

/// What tf says of a transform.
struct TransformAnswer {
  std::optional<geometry_msgs::TransformStamped> transform;
  std::string problem;  ///< why there is none
};

/// Looks up `source` in `target` at `stamp`. Also of stamps so far from all that tf knows that it
/// cannot say by how much: of these tf2 throws something else than of all others.
TransformAnswer findTransform(const tf2::BufferCore& tf, const std::string& target,
                              const std::string& source, const ros::Time& stamp);

}  // namespace hymm
