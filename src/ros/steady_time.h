#pragma once

#include <chrono>

namespace hymm {

/// Seconds of a clock that runs with the wall and never jumps, whatever /clock does.
inline double steadyNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace hymm
