#include "ros/process_usage.h"

#include <sys/resource.h>

namespace hymm {
namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ProcessUsage processUsage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  constexpr double kMegabytesPerUnit = 1024.0 / 1e6;  // Linux counts in KiB
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime),
          kMegabytesPerUnit * static_cast<double>(usage.ru_maxrss)};
}

}  // namespace hymm
