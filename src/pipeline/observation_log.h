#pragma once

#include <filesystem>
#include <string>

#include "cekf/cekf_slam.h"
#include "pipeline/line_file.h"

namespace hymm::core {

/// Writes observations.csv: what became of each observation, for studies of residuals. Columns:
/// t, landmark (its id; -1 tentative, -2 rejected), range, bearing, range_deviation,
/// bearing_deviation, diameter.
class ObservationLog {
 public:
  /// `folder` exists. Touches nothing.
  explicit ObservationLog(const std::filesystem::path& folder);

  /// Throws OutputError if what was added could not be written.
  void add(const ScanOutcome& outcome);

  /// Throws OutputError if what was added could not be written.
  void finish() { lines_.flush(); }

 private:
  LineFile lines_;
};

}  // namespace hymm::core
