#include <boost/make_shared.hpp>
#include <console_bridge/console.h>
#include <geometry_msgs/TransformStamped.h>
#include <hymm/DeadReckoning.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include "common/error.h"
#include "fuzz/harness.h"
#include "ros/sensor_bag.h"
#include "support/temporary_folder.h"

namespace hymm::test {
namespace {

/// tf tells of every senseless transform, and with the last bag goes a library for encrypted ones,
/// to be loaded again with the next. Without either an input takes a tenth of the time.
void quieten() {
  console_bridge::noOutputHandler();
  static const rosbag::Bag kept;
}

/// Without the text of the message's definition, which nobody reads: a fuzzer would spoil little
/// else.
template <class Message>
void write(rosbag::Bag& bag, const std::string& topic, const Message& message, double time_s) {
  namespace traits = ros::message_traits;
  bag.write(topic, ros::Time(time_s), message,
            boost::make_shared<ros::M_string>(ros::M_string{{"topic", topic},
                                                            {"type", traits::datatype(message)},
                                                            {"md5sum", traits::md5sum(message)},
                                                            {"message_definition", ""}}));
}

tf2_msgs::TFMessage mounting() {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.frame_id = "base_link";
  message.transforms[0].child_frame_id = "laser";
  message.transforms[0].transform.rotation.w = 1.0;
  return message;
}

void writeBag(const std::string& path, rosbag::CompressionType compression) {
  sensor_msgs::LaserScan scan;
  scan.ranges.assign(9, 1.0F);
  DeadReckoning motion;
  motion.speed = 1.0;
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  bag.setCompression(compression);
  write(bag, "/tf_static", mounting(), 1.0);
  for (const double time_s : {1.0, 2.0}) {
    write(bag, "scan", scan, time_s);
    write(bag, "dead_reckoning", motion, time_s);
  }
}

}  // namespace

/// A whole bag, to its end.
bool isRead(const std::uint8_t* data, std::size_t size) {
  quieten();
  const std::string path = inputFile(data, size, ".bag");
  try {
    SensorBag bag(path, BagSelection());
    tf2::BufferCore tf;
    bag.readTransforms(tf, "base_link");
    bag.read([](const BagMessage&) {}, [](double) {});
    return true;
  } catch (const core::InputError&) {
    return false;
  }
}

std::map<std::string, std::string> seeds() {
  const TemporaryFolder folder;
  std::map<std::string, std::string> bags;
  for (const auto& [name, compression] : {std::pair{"none.bag", rosbag::compression::Uncompressed},
                                          std::pair{"bz2.bag", rosbag::compression::BZ2},
                                          std::pair{"lz4.bag", rosbag::compression::LZ4}}) {
    writeBag(folder / name, compression);
    bags[name] = folder.read(name);
  }
  return bags;
}

}  // namespace hymm::test
