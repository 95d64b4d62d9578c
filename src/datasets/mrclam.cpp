#include <algorithm>
#include <cmath>
#include <map>

#include "common/error.h"
#include "common/number_text.h"
#include "datasets/file_source.h"
#include "datasets/landmark_recording.h"
#include "datasets/number_table.h"

namespace hymm::core {
namespace {

constexpr int kLastRobotSubject = 5;  // subjects 1 to 5 are the robots themselves

NumberTable readTable(const FileSource& source, const std::string& name, std::size_t columns) {
  const std::string origin = source.origin(name);
  NumberTable table = parseNumberTable(source.read(name), columns, RowEnd::kLine, origin);
  const auto bad = std::find_if_not(table.values.begin(), table.values.end(),
                                    [](double value) { return std::isfinite(value); });
  if (bad != table.values.end()) {
    const auto row = static_cast<std::size_t>(bad - table.values.begin()) / columns;
    throw InputError(origin + ": row " + std::to_string(row + 1) +
                     " holds a number that is not finite; get the file again.");
  }
  if (table.rows() == 0) {
    throw InputError(origin + " holds no rows; give the complete recording.");
  }
  return table;
}

/// A subject or barcode. Throws InputError if it is not a whole number.
int numeralAt(const NumberTable& table, std::size_t row, std::size_t column,
              const std::string& origin) {
  const double value = table.at(row, column);
  if (value != std::floor(value) || std::abs(value) > 1e9) {
    throw InputError(origin + ": row " + std::to_string(row + 1) + " has " + numberText(value) +
                     " where a whole number should stand; get the file again.");
  }
  return static_cast<int>(value);
}

class MrclamReader {
 public:
  MrclamReader(const FileSource& source, int robot, const MrclamNoise& noise)
      : source_(source), robot_("Robot" + std::to_string(robot)), noise_(noise) {
    recording_.name = "MRCLAM robot " + std::to_string(robot);
  }

  LandmarkRecording read() {
    readBarcodes();
    // The truth is for judging, not for running.
    if (source_.contains("Landmark_Groundtruth.dat")) readLandmarks();
    if (source_.contains(robot_ + "_Groundtruth.dat")) readTruth();
    const std::vector<TwistInput> motion = readMotion();
    mergeEvents(motion, readObservations());
    count("observations of other robots, skipped", of_robots_);
    count("observations of unknown barcodes, skipped", unknown_barcodes_);
    count("observations whose range is not positive, skipped", not_positive_);
    count("odometry rows that are not later than the one before, skipped", standing_clock_);
    count("observations out of time order, sorted", out_of_order_);
    return std::move(recording_);
  }

 private:
  void readBarcodes() {
    const std::string name = "Barcodes.dat";
    const NumberTable table = readTable(source_, name, 2);
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const int barcode = numeralAt(table, i, 1, source_.origin(name));
      subject_of_barcode_[barcode] = numeralAt(table, i, 0, source_.origin(name));
    }
  }

  void readLandmarks() {
    const std::string name = "Landmark_Groundtruth.dat";
    const NumberTable table = readTable(source_, name, 5);
    for (std::size_t i = 0; i < table.rows(); ++i) {
      recording_.truth_landmarks.push_back({numeralAt(table, i, 0, source_.origin(name)),
                                            {table.at(i, 1), table.at(i, 2)},
                                            {table.at(i, 3), table.at(i, 4)}});
    }
  }

  void readTruth() {
    const NumberTable table = readTable(source_, robot_ + "_Groundtruth.dat", 4);
    for (std::size_t i = 0; i < table.rows(); ++i) {
      recording_.truth_poses.push_back(
          {table.at(i, 0), {table.at(i, 1), table.at(i, 2), wrapAngle(table.at(i, 3))}});
    }
  }

  std::vector<TwistInput> readMotion() {
    const NumberTable table = readTable(source_, robot_ + "_Odometry.dat", 3);
    std::vector<TwistInput> motion;
    motion.reserve(table.rows());
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const double time_s = table.at(i, 0);
      if (!motion.empty() && time_s <= motion.back().time_s) {
        ++standing_clock_;
        continue;
      }
      motion.push_back({time_s, table.at(i, 1), 0.0, table.at(i, 2)});
    }
    return motion;
  }

  std::vector<ObservationSet> readObservations() {
    const std::string name = robot_ + "_Measurement.dat";
    const NumberTable table = readTable(source_, name, 4);
    std::map<double, ObservationSet> sets;  // observations of one image share its stamp
    double newest_s = table.at(0, 0);
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const double time_s = table.at(i, 0);
      if (time_s < newest_s) ++out_of_order_;
      newest_s = std::max(newest_s, time_s);
      const auto subject = subject_of_barcode_.find(numeralAt(table, i, 1, source_.origin(name)));
      if (subject == subject_of_barcode_.end()) {
        ++unknown_barcodes_;
      } else if (subject->second <= kLastRobotSubject) {
        ++of_robots_;
      } else if (table.at(i, 2) <= 0.0) {
        ++not_positive_;
      } else {
        ObservationSet& set = sets[time_s];
        set.time_s = time_s;
        set.observations.push_back(observationOf(subject->second, table.at(i, 2), table.at(i, 3)));
      }
    }
    std::vector<ObservationSet> ordered;
    ordered.reserve(sets.size());
    for (auto& [time_s, set] : sets) ordered.push_back(std::move(set));
    return ordered;
  }

  Observation observationOf(int subject, double range_m, double bearing_rad) const {
    Observation observation;
    observation.range_m = range_m;
    observation.bearing_rad = wrapAngle(bearing_rad);
    observation.covariance << noise_.range_deviation_m * noise_.range_deviation_m, 0.0, 0.0,
        noise_.bearing_deviation_rad * noise_.bearing_deviation_rad;
    observation.identity = subject;
    return observation;
  }

  /// Motion comes first where stamps are equal.
  void mergeEvents(const std::vector<TwistInput>& motion, std::vector<ObservationSet> sets) {
    recording_.events.reserve(motion.size() + sets.size());
    auto set = sets.begin();
    for (const TwistInput& input : motion) {
      for (; set != sets.end() && set->time_s < input.time_s; ++set) {
        recording_.events.emplace_back(std::move(*set));
      }
      recording_.events.emplace_back(MotionInput(input));
    }
    for (; set != sets.end(); ++set) recording_.events.emplace_back(std::move(*set));
  }

  void count(const std::string& what, std::size_t number) {
    if (number > 0) recording_.counts.push_back({what, number});
  }

  const FileSource& source_;
  std::string robot_;
  MrclamNoise noise_;
  std::map<int, int> subject_of_barcode_;
  std::size_t of_robots_ = 0;
  std::size_t unknown_barcodes_ = 0;
  std::size_t not_positive_ = 0;
  std::size_t standing_clock_ = 0;
  std::size_t out_of_order_ = 0;
  LandmarkRecording recording_;
};

}  // namespace

LandmarkRecording readMrclam(const std::filesystem::path& path, int robot,
                             const MrclamNoise& noise) {
  const FileSource source(path);
  return MrclamReader(source, robot, noise).read();
}

}  // namespace hymm::core
