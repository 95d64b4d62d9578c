#include <console_bridge/console.h>
#include <rosbag/bag.h>
#include <tf2/buffer_core.h>

#include "common/error.h"
#include "input_file.h"
#include "ros/sensor_bag.h"

/// tf tells of every senseless transform, and with the last bag goes a library for encrypted ones,
/// to be loaded again with the next. Without either an input takes a tenth of the time.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  console_bridge::noOutputHandler();
  static const rosbag::Bag kept;
  return 0;
}

/// Any file that calls itself a bag is read to its end, or refused with an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string path = hymm::test::inputFile(data, size, ".bag");
  try {
    hymm::SensorBag bag(path, hymm::BagSelection());
    tf2::BufferCore tf;
    bag.readTransforms(tf);
    bag.read([](const hymm::BagMessage&) {}, [](double) {});
  } catch (const hymm::core::InputError&) {
  }
  return 0;
}
