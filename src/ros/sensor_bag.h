#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <hymm/PropertySample.h>
#include <rosbag/bag.h>
#include <tf2/buffer_core.h>

#include "ros/sensor_queue.h"
#include "ros/stamp_comparison.h"

namespace hymm {

/// What a run takes from a bag.
using BagMessage = std::variant<SensorMessage, PropertySample::ConstPtr>;

/// Which messages of a bag a run wants.
struct BagSelection {
  std::string motion_input = "dead_reckoning";    ///< or "odom"
  std::string observation_input = "scan";         ///< or "points", "detections"
  std::map<std::string, std::string> remappings;  ///< our name of a topic to the bag's
  bool needs_gps = false;                         ///< the filter fuses it
};

/// The sensor messages of a bag, in the order in which `rosbag play` would publish them. Topics
/// match with or without their leading slash.
class SensorBag {
 public:
  /// Opens the bag and finds the topics. Throws core::InputError with a sentence that names the
  /// bag and says what to do: it cannot be opened, is no bag, is empty, was not closed or is cut
  /// off, lacks a topic (those found are listed), or has another type of message under its name. An
  /// input that the run can do without, and that nobody named, is left out in that last case.
  SensorBag(const std::string& path, const BagSelection& selection);

  /// Our names of the topics that a run can take.
  static std::vector<std::string> inputs();

  /// Fills `tf` with /tf_static and with the first seconds of /tf, and with more of it until
  /// it tells where the sensor stands on `base_frame`: old recordings repeat fixed transforms
  /// there. Messages that cannot be decoded, and transforms that cannot be used, are skipped and
  /// counted.
  void readTransforms(tf2::BufferCore& tf, const std::string& base_frame);

  /// Calls `take` with each message, and `progress` (from 0 to 1) now and then. Messages that
  /// cannot be decoded are skipped and counted. Throws core::InputError if the bag breaks off.
  void read(const std::function<void(const BagMessage&)>& take,
            const std::function<void(double)>& progress);

  /// What was left out, skipped and refused so far, and how often.
  const std::map<std::string, std::size_t>& incidents() const { return incidents_; }

  /// By what clocks motion and scans were stamped, of what was read.
  const StampComparison& stamps() const { return stamps_; }

 private:
  using Decoder = BagMessage (*)(const rosbag::MessageInstance&);
  struct Topic {
    std::string type;
    std::size_t messages = 0;
  };

  template <class Decode>
  void skippingUndecodable(const rosbag::MessageInstance& instance, const Decode& decode);
  void compareStamp(const BagMessage& message, double recorded_s);
  void listTopics();
  void choose(const std::string& name, const BagSelection& selection, bool required);
  void addTransforms(const rosbag::MessageInstance& instance, bool are_fixed, tf2::BufferCore& tf);
  std::string firstSensorFrame();
  std::string found() const;

  std::string path_;
  rosbag::Bag bag_;
  std::map<std::string, Topic> topics_;    ///< everything in the bag
  std::map<std::string, Decoder> chosen_;  ///< by the bag's name of the topic
  std::vector<std::string> observations_;  ///< topics among these
  std::map<std::string, std::size_t> incidents_;
  StampComparison stamps_;
};

}  // namespace hymm
