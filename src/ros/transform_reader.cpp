#include "ros/transform_reader.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 1000;
constexpr double kNormTolerance = 1e-2;  // of the squared norm, as tf2 has it
// tf2 adds to stamps how long it keeps them, which is seconds.
constexpr std::uint32_t kLast_s = std::numeric_limits<std::uint32_t>::max() - 86400;

bool isFinite(const geometry_msgs::Transform& transform) {
  const auto& p = transform.translation;
  const auto& q = transform.rotation;
  return std::isfinite(p.x + p.y + p.z) && std::isfinite(q.x + q.y + q.z + q.w);
}

}  // namespace

std::string problemOf(const geometry_msgs::TransformStamped& transform) {
  const auto& q = transform.transform.rotation;
  const double norm2 = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (transform.header.frame_id.empty() || transform.child_frame_id.empty()) {
    return "it does not name both its frames";
  }
  if (transform.header.frame_id == transform.child_frame_id) return "its two frames are the same";
  if (!isFinite(transform.transform)) return "it is not finite";
  if (std::abs(norm2 - 1.0) > kNormTolerance) return "its rotation is no unit quaternion";
  if (transform.header.stamp.sec > kLast_s) return "its stamp is at the end of time";
  return {};
}

TransformReader::TransformReader(tf2::BufferCore& tf, CauseLog& causes) : tf_(tf), causes_(causes) {
  handle_.setCallbackQueue(&queue_);
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;
  const boost::function<void(const Event&)> changing = [this](const Event& e) { take(e, false); };
  const boost::function<void(const Event&)> fixed = [this](const Event& e) { take(e, true); };
  changing_ = handle_.subscribe<tf2_msgs::TFMessage>("/tf", kQueue, changing);
  static_ = handle_.subscribe<tf2_msgs::TFMessage>("/tf_static", kQueue, fixed);
  spinner_.start();
}

TransformReader::~TransformReader() { spinner_.stop(); }

void TransformReader::take(const ros::MessageEvent<const tf2_msgs::TFMessage>& event,
                           bool is_static) {
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    const std::string problem = problemOf(transform);
    if (problem.empty()) {
      tf_.setTransform(transform, event.getPublisherName(), is_static);
    } else {
      causes_.count("transforms refused: " + problem, "A transform '" + transform.header.frame_id +
                                                          "' -> '" + transform.child_frame_id +
                                                          "' from " + event.getPublisherName() +
                                                          " is refused: " + problem + ".");
    }
  }
}

}  // namespace hymm
