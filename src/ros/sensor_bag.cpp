#include "ros/sensor_bag.h"

#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include <boost/make_shared.hpp>
#include <ros/serialization.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include "common/error.h"
#include "ros/bag_errors.h"
#include "ros/transform_lookup.h"
#include "ros/transform_reader.h"

namespace hymm {
namespace {

constexpr double kTransformsFromTf_s = 10.0;  // from the first one
constexpr std::size_t kMessagesPerProgress = 512;

// The largest message that is believed: 30 million ranges with intensities. Damage makes more.
constexpr std::uint32_t kLargestMessage_bytes = 1U << 28U;

/// Walks over serialised fields, to see whether the lengths of arrays fit before ROS allocates
/// them.
class FieldWalker {
 public:
  explicit FieldWalker(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  void skip(std::size_t count) {
    if (count > bytes_.size() - place_) throw std::runtime_error("a length beyond the message");
    place_ += count;
  }

  std::uint32_t readCount() {
    std::uint32_t count = 0;
    const std::size_t begin = place_;
    skip(sizeof(count));
    std::memcpy(&count, bytes_.data() + begin, sizeof(count));
    return count;
  }

  void skipArray(std::size_t element_bytes) { skip(readCount() * element_bytes); }

  void skipHeader() {
    skip(12);  // sequence number and stamp
    skipArray(1);
  }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::size_t place_ = 0;
};

/// Throws if a message of the type holds longer arrays than bytes.
template <class Message>
void checkLengths(const std::vector<std::uint8_t>& bytes) {
  FieldWalker walker(bytes);
  if constexpr (std::is_same_v<Message, sensor_msgs::LaserScan>) {
    walker.skipHeader();
    walker.skip(7 * sizeof(float));
    walker.skipArray(sizeof(float));
    walker.skipArray(sizeof(float));
  } else if constexpr (std::is_same_v<Message, sensor_msgs::PointCloud2>) {
    walker.skipHeader();
    walker.skip(2 * sizeof(std::uint32_t));
    for (std::uint32_t fields = walker.readCount(); fields > 0; --fields) {
      walker.skipArray(1);
      walker.skip(2 * sizeof(std::uint32_t) + 1);
    }
    walker.skip(1 + 2 * sizeof(std::uint32_t));
    walker.skipArray(1);
  } else if constexpr (std::is_same_v<Message, LandmarkObservations>) {
    walker.skipHeader();
    walker.skipArray(8 * sizeof(double) + sizeof(std::uint8_t) + sizeof(std::int32_t));
  } else if constexpr (std::is_same_v<Message, tf2_msgs::TFMessage>) {
    for (std::uint32_t transforms = walker.readCount(); transforms > 0; --transforms) {
      walker.skipHeader();
      walker.skipArray(1);
      walker.skip(7 * sizeof(double));
    }
  } else if constexpr (std::is_same_v<Message, PropertySample>) {
    walker.skipHeader();
    walker.skipArray(1);
    walker.skip(10 * sizeof(double));
    walker.skipArray(1);
  }
}

template <class Message>
boost::shared_ptr<const Message> decodeAs(const rosbag::MessageInstance& instance) {
  if (instance.getMD5Sum() != ros::message_traits::md5sum<Message>()) {
    throw std::runtime_error("another definition of the message");
  }
  const std::uint32_t size = instance.size();
  if (size > kLargestMessage_bytes) throw std::runtime_error("a message of impossible size");
  std::vector<std::uint8_t> bytes(size);
  ros::serialization::OStream out(bytes.data(), size);
  instance.write(out);
  checkLengths<Message>(bytes);
  auto message = boost::make_shared<Message>();
  ros::serialization::IStream in(bytes.data(), size);
  ros::serialization::deserialize(in, *message);
  return message;
}

template <class Message>
BagMessage decode(const rosbag::MessageInstance& instance) {
  return decodeAs<Message>(instance);
}

struct Kind {
  std::string type;
  BagMessage (*decode)(const rosbag::MessageInstance&);
};

template <class Message>
Kind kindOf() {
  return {ros::message_traits::datatype<Message>(), decode<Message>};
}

/// Of each input, by our name of its topic.
const std::map<std::string, Kind>& kinds() {
  static const std::map<std::string, Kind> kinds = {{"dead_reckoning", kindOf<DeadReckoning>()},
                                                    {"odom", kindOf<nav_msgs::Odometry>()},
                                                    {"scan", kindOf<sensor_msgs::LaserScan>()},
                                                    {"points", kindOf<sensor_msgs::PointCloud2>()},
                                                    {"detections", kindOf<LandmarkObservations>()},
                                                    {"property_samples", kindOf<PropertySample>()},
                                                    {"gps/fix", kindOf<sensor_msgs::NavSatFix>()}};
  return kinds;
}

}  // namespace

std::vector<std::string> SensorBag::inputs() {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds()) names.push_back(name);
  return names;
}

SensorBag::SensorBag(const std::string& path, const BagSelection& selection) : path_(path) {
  withBagErrors(path_, [&] {
    openBag(bag_, path_);
    listTopics();
  });
  choose(selection.observation_input, selection, true);
  for (const auto& [topic, decoder] : chosen_) observations_.push_back(topic);
  choose(selection.motion_input, selection, true);
  choose("gps/fix", selection, false);
  choose("property_samples", selection, false);
}

void SensorBag::listTopics() {
  rosbag::View all(bag_);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    topics_[connection->topic].type = connection->datatype;
  }
  std::size_t messages = 0;
  for (auto& [name, topic] : topics_) {
    topic.messages = rosbag::View(bag_, rosbag::TopicQuery(name)).size();
    messages += topic.messages;
  }
  if (messages == 0) throw core::InputError(path_ + ": the bag is empty, it holds no messages.");
}

void SensorBag::choose(const std::string& name, const BagSelection& selection, bool required) {
  const auto remapping = selection.remappings.find(name);
  const std::string wanted = remapping == selection.remappings.end() ? name : remapping->second;
  const Kind& kind = kinds().at(name);
  const bool is_named = remapping != selection.remappings.end();
  const bool must_fit = required || is_named || (name == "gps/fix" && selection.needs_gps);
  bool is_there = false;
  for (const auto& [topic, content] : topics_) {
    if (withoutSlash(topic) != withoutSlash(wanted) || content.messages == 0) continue;
    if (content.type != kind.type && !must_fit) {
      incidents_["messages of " + topic + " left out: it holds " + content.type + ", not " +
                 kind.type] = content.messages;
      continue;
    }
    if (content.type != kind.type) {
      throw core::InputError(path_ + ": topic " + topic + " holds " + content.type + ", but " +
                             kind.type + " is needed. " + found());
    }
    is_there = true;
    chosen_[topic] = kind.decode;
  }
  if (!required || is_there) return;
  throw core::InputError(path_ + ": there are no messages on topic '" + wanted + "' (" + kind.type +
                         "). " + found() + " Another name can be given by `--topic " + name +
                         ":=/NAME`, another input by motion_input or observation_input of "
                         "cekf_slam.");
}

std::string SensorBag::found() const {
  std::string list;
  for (const auto& [name, topic] : topics_) {
    list += (list.empty() ? "" : ", ") + name + " (" + topic.type + ", " +
            std::to_string(topic.messages) + ")";
  }
  return "Found in the bag: " + list + ".";
}

template <class Decode>
void SensorBag::skippingUndecodable(const rosbag::MessageInstance& instance, const Decode& decode) {
  try {
    decode();
  } catch (const rosbag::BagException&) {
    throw;
  } catch (const std::exception&) {
    ++incidents_["messages of " + instance.getTopic() + " that could not be decoded"];
  }
}

void SensorBag::addTransforms(const rosbag::MessageInstance& instance, bool are_fixed,
                              tf2::BufferCore& tf) {
  boost::shared_ptr<const tf2_msgs::TFMessage> message;
  skippingUndecodable(instance, [&] { message = decodeAs<tf2_msgs::TFMessage>(instance); });
  if (!message) return;
  for (const geometry_msgs::TransformStamped& transform : message->transforms) {
    const std::string problem = problemOf(transform);
    if (problem.empty()) {
      tf.setTransform(transform, path_, are_fixed);
    } else {
      ++incidents_["transforms refused: " + problem];
    }
  }
}

/// The frame of the first message that the filter gets to see; empty if it cannot be told.
std::string SensorBag::firstSensorFrame() {
  rosbag::View view(bag_, rosbag::TopicQuery(observations_));
  for (const rosbag::MessageInstance& instance : view) {
    try {
      const BagMessage message = chosen_.at(instance.getTopic())(instance);
      return withoutSlash(headerOf(std::get<SensorMessage>(message)).frame_id);
    } catch (const rosbag::BagException&) {
      throw;
    } catch (const std::exception&) {  // read() counts it
    }
  }
  return {};
}

void SensorBag::readTransforms(tf2::BufferCore& tf, const std::string& base_frame) {
  const auto topics = [](const char* name) {
    return rosbag::TopicQuery(std::vector<std::string>{name, std::string("/") + name});
  };
  withBagErrors(path_, [&] {
    rosbag::View fixed(bag_, topics("tf_static"));
    for (const rosbag::MessageInstance& instance : fixed) addTransforms(instance, true, tf);
    const std::string sensor = firstSensorFrame();
    const auto isPlaced = [&] {
      return sensor.empty() || tf.canTransform(withoutSlash(base_frame), sensor, ros::Time(0));
    };
    rosbag::View moving(bag_, topics("tf"));
    std::optional<double> begin_s;
    for (const rosbag::MessageInstance& instance : moving) {
      const double time_s = instance.getTime().toSec();
      if (!begin_s) begin_s = time_s;
      if (time_s - *begin_s > kTransformsFromTf_s && isPlaced()) break;
      addTransforms(instance, false, tf);
    }
  });
}

void SensorBag::compareStamp(const BagMessage& message, double recorded_s) {
  const auto* sensor = std::get_if<SensorMessage>(&message);
  if (sensor == nullptr || std::holds_alternative<sensor_msgs::NavSatFix::ConstPtr>(*sensor))
    return;
  const auto source =
      isScan(*sensor) ? StampComparison::Source::kScan : StampComparison::Source::kMotion;
  stamps_.add(source, headerOf(*sensor).stamp.toSec(), recorded_s);
}

void SensorBag::read(const std::function<void(const BagMessage&)>& take,
                     const std::function<void(double)>& progress) {
  std::vector<std::string> names;
  for (const auto& [name, decoder] : chosen_) names.push_back(name);
  withBagErrors(path_, [&] {
    rosbag::View view(bag_, rosbag::TopicQuery(names));
    const double total = view.size();
    std::size_t seen = 0;
    for (const rosbag::MessageInstance& instance : view) {
      if (seen++ % kMessagesPerProgress == 0) progress(static_cast<double>(seen) / total);
      std::optional<BagMessage> message;
      skippingUndecodable(instance, [&] { message = chosen_.at(instance.getTopic())(instance); });
      if (!message) continue;
      compareStamp(*message, instance.getTime().toSec());
      take(*message);
    }
    progress(1.0);
  });
}

}  // namespace hymm
