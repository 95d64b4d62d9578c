#include "datasets/acfr_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/angles.h"
#include "common/error.h"
#include "common/number_text.h"

namespace hymm::core {
namespace {

constexpr double kEarliestStamp_s = 1e-9;  // ROS keeps the stamp 0 for "not set"
constexpr double kLatestStamp_s = 4e9;     // its seconds are 32 bits wide
constexpr double kStampResolution_s = 1e-3;

constexpr double kFirstBearing_rad = -kPi / 2.0;  // the car's right
constexpr double kBeamSpacing_rad = kPi / 360.0;

constexpr std::array<const char*, 3> kSensorNames = {"GPS", "dead reckoning", "laser"};

double checkedStamp(double time_s, std::size_t row, const std::string& origin) {
  if (std::isfinite(time_s) && time_s >= 0.0 && time_s <= kLatestStamp_s) {
    return std::max(time_s, kEarliestStamp_s);
  }
  throw InputError(origin + ", row " + std::to_string(row + 1) + ": the time " +
                   numberText(time_s) +
                   " s is not between 0 and 4e9; correct it or get the file again.");
}

}  // namespace

double AcfrRecording::timeOf(const Event& event) const {
  switch (event.sensor) {
    case AcfrSensor::kGps:
      return fixes[event.index].time_s;
    case AcfrSensor::kMotion:
      return motion[event.index].time_s;
    case AcfrSensor::kLaser:
      break;
  }
  return scans[event.index].time_s;
}

AcfrBuilder::AcfrBuilder(std::string form) { recording_.form = std::move(form); }

void AcfrBuilder::reserve(std::size_t scans, std::size_t motion) {
  recording_.scans.reserve(scans);
  recording_.motion.reserve(motion);
  recording_.events.reserve(scans + motion);
}

void AcfrBuilder::addScan(double time_s, const Beams& ranges_m, const std::string& origin) {
  LaserScan scan;
  scan.time_s = checkedStamp(time_s, recording_.scans.size(), origin);
  scan.angle_min_rad = kFirstBearing_rad;
  scan.angle_increment_rad = kBeamSpacing_rad;
  scan.range_max_m = kAcfrNoReturn_m;
  scan.ranges_m.reserve(kBeams);
  for (const double range_m : ranges_m) {
    if (range_m >= kAcfrNoReturn_m) {
      scan.ranges_m.push_back(std::numeric_limits<float>::infinity());
    } else if (range_m >= 0.0) {
      scan.ranges_m.push_back(static_cast<float>(range_m));
    } else {  // negative or NaN
      scan.ranges_m.push_back(std::numeric_limits<float>::quiet_NaN());
      ++invalid_ranges_;
    }
  }
  recording_.scans.push_back(std::move(scan));
}

void AcfrBuilder::addScan(double time_s, const Beams& ranges_m, const Beams& intensities,
                          const std::string& origin) {
  addScan(time_s, ranges_m, origin);
  auto& scan = recording_.scans.back();
  scan.intensities.resize(kBeams);
  std::transform(intensities.begin(), intensities.end(), scan.intensities.begin(),
                 [](double intensity) { return static_cast<float>(intensity); });
}

void AcfrBuilder::addMotion(double time_s, double speed_mps, double steering_rad,
                            const std::string& origin) {
  const double stamp_s = checkedStamp(time_s, recording_.motion.size(), origin);
  recording_.motion.push_back({stamp_s, speed_mps, steering_rad});
}

void AcfrBuilder::addFix(double time_s, double east_m, double north_m, const std::string& origin) {
  const double stamp_s = checkedStamp(time_s, recording_.fixes.size(), origin);
  recording_.fixes.push_back({stamp_s, east_m, north_m});
}

std::size_t AcfrBuilder::rowsOf(AcfrSensor sensor) const {
  switch (sensor) {
    case AcfrSensor::kGps:
      return recording_.fixes.size();
    case AcfrSensor::kMotion:
      return recording_.motion.size();
    case AcfrSensor::kLaser:
      break;
  }
  return recording_.scans.size();
}

void AcfrBuilder::addEvent(double time_s, double sensor, double index, const std::string& origin) {
  ++order_rows_;
  const auto refuse = [&](const std::string& problem) {
    throw InputError(origin + ", row " + std::to_string(order_rows_) + ": " + problem +
                     "; correct it or get the file again.");
  };
  if (sensor != 1.0 && sensor != 2.0 && sensor != 3.0) {
    refuse("the sensor is " + numberText(sensor) +
           ", but must be 1 (GPS), 2 (dead reckoning) or 3 (laser)");
  }
  if (!(index >= 1.0) || index != std::floor(index) || index > 1e9) {
    refuse("the index " + numberText(index) + " is not a row number, which counts from 1");
  }
  const AcfrRecording::Event event{static_cast<AcfrSensor>(static_cast<int>(sensor)),
                                   static_cast<std::size_t>(index) - 1};
  if (event.index >= rowsOf(event.sensor)) {
    ++missing_rows_[static_cast<std::size_t>(event.sensor) - 1];
    return;
  }
  // Not <=, so that a NaN counts as another stamp.
  if (!(std::abs(recording_.timeOf(event) - time_s) < kStampResolution_s)) ++other_stamps_;
  recording_.events.push_back(event);
}

void AcfrBuilder::orderByTime() {
  auto& events = recording_.events;
  for (const AcfrSensor sensor : {AcfrSensor::kMotion, AcfrSensor::kLaser, AcfrSensor::kGps}) {
    for (std::size_t i = 0; i < rowsOf(sensor); ++i) events.push_back({sensor, i});
  }
  std::stable_sort(events.begin(), events.end(), [&](const auto& a, const auto& b) {
    return recording_.timeOf(a) < recording_.timeOf(b);
  });
}

bool AcfrBuilder::isUsable(const AcfrRecording::Event& event) const {
  return event.sensor != AcfrSensor::kMotion || isFinite(recording_.motion[event.index]);
}

AcfrRecording AcfrBuilder::finish() {
  countUnreferencedRows();
  auto& events = recording_.events;
  const std::size_t before = events.size();
  events.erase(std::remove_if(events.begin(), events.end(),
                              [&](const auto& event) { return !isUsable(event); }),
               events.end());
  count("dead-reckoning events whose speed or steering is not finite, skipped",
        before - events.size());
  for (std::size_t i = 0; i < missing_rows_.size(); ++i) {
    count(std::string(kSensorNames[i]) + " events whose row is missing, skipped", missing_rows_[i]);
  }
  count("events whose stamp differs from their row's, the row's taken", other_stamps_);
  countOutOfOrder();
  count("ranges that are negative or not a number, made NaN", invalid_ranges_);
  count("fixes without a position",
        static_cast<std::size_t>(std::count_if(
            recording_.fixes.begin(), recording_.fixes.end(), [](const LocalFix& fix) {
              return !std::isfinite(fix.east_m) || !std::isfinite(fix.north_m);
            })));
  return std::move(recording_);
}

void AcfrBuilder::countOutOfOrder() {
  std::size_t out_of_order = 0;
  double newest_s = 0.0;
  for (const auto& event : recording_.events) {
    const double time_s = recording_.timeOf(event);
    if (time_s < newest_s) ++out_of_order;
    newest_s = std::max(newest_s, time_s);
  }
  count("events stamped before one that precedes them", out_of_order);
}

void AcfrBuilder::countUnreferencedRows() {
  std::array<std::vector<bool>, 3> referenced;
  for (std::size_t i = 0; i < referenced.size(); ++i) {
    referenced[i].resize(rowsOf(static_cast<AcfrSensor>(i + 1)));
  }
  for (const auto& event : recording_.events) {
    referenced[static_cast<std::size_t>(event.sensor) - 1][event.index] = true;
  }
  for (std::size_t i = 0; i < referenced.size(); ++i) {
    count(std::string(kSensorNames[i]) + " rows that no event refers to, left out",
          static_cast<std::size_t>(std::count(referenced[i].begin(), referenced[i].end(), false)));
  }
}

void AcfrBuilder::count(const std::string& what, std::size_t number) {
  if (number > 0) recording_.counts.push_back({what, number});
}

}  // namespace hymm::core
