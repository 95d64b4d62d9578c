#pragma once

namespace hymm {

/// What this process has used so far.
struct ProcessUsage {
  double cpu_s = 0.0;        ///< user and system time of all threads
  double peak_rss_mb = 0.0;  ///< largest resident memory, 10^6 bytes
};

ProcessUsage processUsage();

}  // namespace hymm
