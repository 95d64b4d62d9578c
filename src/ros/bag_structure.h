#pragma once

#include <stdexcept>
#include <string>

namespace hymm {

/// A file that is no bag, or one of an older version.
struct NotABag : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A bag whose end is missing.
struct BagCutOff : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Walks over the records of a bag of version 2.0 before ROS's reader does, which believes every
/// length and place that it reads: damaged ones make it take gigabytes, or read outside of its
/// memory. Throws NotABag, BagCutOff, or std::runtime_error that says what does not fit, and
/// where; files of other versions are refused. Returns without looking further at bags without an
/// index, which that reader refuses itself. Chunks that are compressed carry checksums, and are not
/// unpacked here.
void checkBagStructure(const std::string& path);

}  // namespace hymm
