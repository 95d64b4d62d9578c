#pragma once

#include <array>
#include <string>
#include <vector>

#include "datasets/acfr_recording.h"

namespace hymm::core {

/// Puts an AcfrRecording together from rows, whatever file they come from: converts bearings,
/// ranges and stamps, refuses impossible stamps, and counts what has to be left out.
class AcfrBuilder {
 public:
  static constexpr std::size_t kBeams = 361;
  using Beams = std::array<double, kBeams>;

  explicit AcfrBuilder(std::string form);

  void reserve(std::size_t scans, std::size_t motion);

  /// `ranges_m[0]` points to the car's right, the last one to its left. `origin` names the file in
  /// sentences. Throws InputError for a stamp that is not finite or negative.
  void addScan(double time_s, const Beams& ranges_m, const std::string& origin);
  void addScan(double time_s, const Beams& ranges_m, const Beams& intensities,
               const std::string& origin);
  void addMotion(double time_s, double speed_mps, double steering_rad, const std::string& origin);
  void addFix(double time_s, double east_m, double north_m, const std::string& origin);

  /// The next event of the recording's own order; `index` counts from 1, as in the files. A row
  /// that is not there is skipped and counted. Throws InputError for numbers that mean nothing.
  void addEvent(double time_s, double sensor, double index, const std::string& origin);

  /// Orders all rows by stamp instead; of equal stamps motion comes first, then scans, then fixes.
  void orderByTime();

  AcfrRecording finish();

 private:
  bool isUsable(const AcfrRecording::Event& event) const;
  std::size_t rowsOf(AcfrSensor sensor) const;
  void countOutOfOrder();
  void countUnreferencedRows();
  void count(const std::string& what, std::size_t number);

  AcfrRecording recording_;
  std::array<std::size_t, 3> missing_rows_{};  ///< by sensor - 1
  std::size_t order_rows_ = 0;
  std::size_t other_stamps_ = 0;
  std::size_t invalid_ranges_ = 0;
};

}  // namespace hymm::core
