#include "tools/bag_output.h"

namespace hymm {

void BagOutput::CloseAndDelete::operator()(rosbag::Bag* bag) const {
  try {
    bag->close();
  } catch (const std::exception&) {
    // The bag's own destructor would write once more, fail again and abort the program. Nobody
    // but that destructor can free what the bag holds, so it stays.
    return;
  }
  delete bag;
}

BagOutput::BagOutput(const std::filesystem::path& target) : file_(target), bag_(new rosbag::Bag) {
  bag_->open(file_.path().string(), rosbag::bagmode::Write);
}

void BagOutput::complete() {
  bag_->close();
  // A full disk may show only now: a bag whose end is missing cannot be opened.
  rosbag::Bag(file_.path().string(), rosbag::bagmode::Read).close();
  file_.complete();
}

core::InputError writingFailed(const std::filesystem::path& target,
                               const rosbag::BagException& error) {
  return core::InputError(target.string() + " cannot be written (" + error.what() +
                          "); check that the disk has room and the folder can be written to.");
}

}  // namespace hymm
