#include "common/cpu_timer.h"

#include <ctime>

namespace hymm::core {

double threadCpuTime_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace hymm::core
