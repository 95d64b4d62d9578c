#pragma once

#include <deque>

#include <std_msgs/Header.h>

namespace hymm {

/// Headers of scans that wait for their result. The core knows time as seconds in a double, which
/// is coarser than a stamp's nanoseconds; results go out with the stamp that came in.
class ScanHeaders {
 public:
  void remember(const std_msgs::Header& header);

  /// The header of the scan of that time, which is forgotten with those before it. If there is none
  /// (it cannot be), a header made of the time.
  std_msgs::Header take(double time_s);

 private:
  std::deque<std_msgs::Header> headers_;
};

}  // namespace hymm
