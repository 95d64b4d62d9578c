#include "common/error.h"
#include "datasets/file_source.h"
#include "input_file.h"

/// Any file that calls itself a .zip archive is listed and unpacked, or refused with an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const hymm::core::FileSource source(hymm::test::inputFile(data, size, ".zip"));
    source.read("LASER.txt");
  } catch (const hymm::core::InputError&) {
  }
  return 0;
}
