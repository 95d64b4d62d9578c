#pragma once

#include <rapidcheck.h>

namespace hymm::test {

/// Any integer in [low, high), for use inside a property. Unlike rc::gen::inRange alone, the whole
/// range from the first case on.
template <typename Integer>
Integer anyInteger(Integer low, Integer high) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(low, high));
}

/// Any number in [low, high].
inline double anyNumber(double low, double high) {
  return low + anyInteger(0, 1'000'001) * 1e-6 * (high - low);
}

}  // namespace hymm::test
