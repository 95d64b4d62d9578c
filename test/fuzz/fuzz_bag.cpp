#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>

#include "input_file.h"
#include "ros/bag_errors.h"

/// Any file that calls itself a bag is read to its end, or refused with an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string path = hymm::test::inputFile(data, size, ".bag");
  try {
    hymm::checkBag(path);
    hymm::withBagErrors(path, [&] {
      const rosbag::Bag bag(path, rosbag::bagmode::Read);
      for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
        message.instantiate<sensor_msgs::LaserScan>();
      }
    });
  } catch (const hymm::core::InputError&) {
  }
  return 0;
}
