#pragma once

#include <filesystem>
#include <memory>

#include <rosbag/bag.h>

#include "common/error.h"
#include "common/unfinished_file.h"

namespace hymm {

/// A bag in the making, which gets its name when it is complete. A failure, a full disk included,
/// leaves nothing behind. Throws core::OutputError where the file cannot be made or finished.
class BagOutput {
 public:
  explicit BagOutput(const std::filesystem::path& target);

  rosbag::Bag& bag() { return *bag_; }

  /// Closes the bag, checks that it can be opened, and gives it its name.
  void complete();

 private:
  struct CloseAndDelete {
    void operator()(rosbag::Bag* bag) const;
  };

  core::UnfinishedFile file_;
  std::unique_ptr<rosbag::Bag, CloseAndDelete> bag_;
};

/// What to tell when writing to the bag failed.
core::InputError writingFailed(const std::filesystem::path& target,
                               const rosbag::BagException& error);

}  // namespace hymm
