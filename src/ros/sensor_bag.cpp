#include "ros/sensor_bag.h"

#include <stdexcept>

#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include "common/error.h"
#include "ros/bag_errors.h"

namespace hymm {
namespace {

constexpr double kTransformsFromTf_s = 10.0;
constexpr std::size_t kMessagesPerProgress = 512;

template <class Message>
SensorMessage decode(const rosbag::MessageInstance& instance) {
  boost::shared_ptr<const Message> message = instance.instantiate<Message>();
  if (!message) throw std::runtime_error("another definition of the message");
  return message;
}

struct Kind {
  std::string type;
  std::string md5;
  SensorMessage (*decode)(const rosbag::MessageInstance&);
};

template <class Message>
Kind kindOf() {
  return {ros::message_traits::datatype<Message>(), ros::message_traits::md5sum<Message>(),
          decode<Message>};
}

Kind kindOfTopic(const std::string& name) {
  if (name == "dead_reckoning") return kindOf<DeadReckoning>();
  if (name == "odom") return kindOf<nav_msgs::Odometry>();
  if (name == "scan") return kindOf<sensor_msgs::LaserScan>();
  if (name == "detections") return kindOf<LandmarkObservations>();
  return kindOf<sensor_msgs::NavSatFix>();
}

std::string withoutSlash(const std::string& topic) {
  return !topic.empty() && topic.front() == '/' ? topic.substr(1) : topic;
}

}  // namespace

SensorBag::SensorBag(const std::string& path, const BagSelection& selection) : path_(path) {
  withBagErrors(path_, [&] {
    bag_.open(path_, rosbag::bagmode::Read);
    listTopics();
  });
  choose(selection.observation_input, selection, true);
  choose(selection.motion_input, selection, true);
  choose("gps/fix", selection, false);
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
  const Kind kind = kindOfTopic(name);
  bool is_there = false;
  for (const auto& [topic, content] : topics_) {
    if (withoutSlash(topic) != withoutSlash(wanted) || content.messages == 0) continue;
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

void SensorBag::readTransforms(tf2::BufferCore& tf) const {
  withBagErrors(path_, [&] {
    const auto read = [&](const std::string& name, rosbag::View& view) {
      for (const rosbag::MessageInstance& instance : view) {
        const auto message = instance.instantiate<tf2_msgs::TFMessage>();
        if (!message) continue;
        for (const auto& transform : message->transforms) {
          tf.setTransform(transform, path_, name == "tf_static");
        }
      }
    };
    rosbag::View fixed(bag_,
                       rosbag::TopicQuery(std::vector<std::string>{"/tf_static", "tf_static"}));
    read("tf_static", fixed);
    const ros::Time begin = rosbag::View(bag_).getBeginTime();
    rosbag::View moving(bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "tf"}), begin,
                        begin + ros::Duration(kTransformsFromTf_s));
    read("tf", moving);
  });
}

void SensorBag::read(const std::function<void(const SensorMessage&)>& take,
                     const std::function<void(double)>& progress) {
  std::vector<std::string> names;
  for (const auto& [name, decoder] : chosen_) names.push_back(name);
  withBagErrors(path_, [&] {
    rosbag::View view(bag_, rosbag::TopicQuery(names));
    const double total = view.size();
    std::size_t seen = 0;
    for (const rosbag::MessageInstance& instance : view) {
      if (seen++ % kMessagesPerProgress == 0) progress(static_cast<double>(seen) / total);
      std::optional<SensorMessage> message;
      try {
        message = chosen_.at(instance.getTopic())(instance);
      } catch (const rosbag::BagException&) {
        throw;
      } catch (const std::exception&) {
        ++undecodable_[instance.getTopic()];
      }
      if (message) take(*message);
    }
    progress(1.0);
  });
}

}  // namespace hymm
