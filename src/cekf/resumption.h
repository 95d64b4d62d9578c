#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/pose2.h"

namespace hymm::core {

// How CekfSlam goes back to a scan in good order, waits there while another filter looks for the
// vehicle, and goes on from there:
//
//   slam.keepLocalStates(duration)      once; from then on the scans of so long can be gone back to
//   slam.suspend(T0)                    doubt: back to T0, where it waits; what comes is kept
//   slam.requestVehicleAmongLandmarks() what the search begins with: as of T0
//   slam.resume(T0, path)               found: the loop closes, and everything since is replayed
//   slam.resumeWithoutClosing(T0)       not found: on by dead reckoning
//
// resume() and resumeWithoutClosing() work without suspend(), too, as long as T0 is still kept; the
// map asked for is then not as of T0.

/// Where base_link was at a scan, in the map frame as it was when CekfSlam was suspended.
struct PlaceAtScan {
  double time_s = 0.0;
  Pose2 T_map_base;
};

/// What came of going back to an earlier scan.
struct Resumption {
  enum class Refusal {
    kNotRefused,
    kNotKept,       ///< the scan is not among those that can be gone back to
    kUnusablePath,  ///< empty, not finite, not in the order of time, or of other scans than are
                    ///< kept
    kNothingPlain,  ///< no scan of the path shows enough landmarks beyond doubt
    kContradiction  ///< what it shows contradicts the covariances, even with the vehicle's inflated
  };

  Refusal refusal = Refusal::kNotRefused;
  std::string reason;         ///< a sentence: what was done, or why not and what to do
  double closed_s = 0.0;      ///< stamp of the scan that closed the loop
  int closing_pairs = 0;      ///< observations and landmarks that closed it, jointly
  double chi_square = 0.0;    ///< of the joint innovation
  double inflation = 1.0;     ///< times that the covariance of the vehicle's pose was taken
  double correction_m = 0.0;  ///< of the vehicle, by the closing
  std::size_t scans = 0;      ///< gone over again, of which the first ones moved the vehicle only

  bool accepted() const { return refusal == Refusal::kNotRefused; }
};

/// What can be gone back to, by the stamps of scans.
struct LocalStateSpan {
  double oldest_s = 0.0;
  double newest_s = 0.0;
  std::size_t scans = 0;
  std::size_t bytes = 0;  ///< that the local states take, without the events between them
};

}  // namespace hymm::core
