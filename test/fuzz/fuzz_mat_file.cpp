#include "common/error.h"
#include "datasets/mat_file.h"
#include "input_file.h"

/// Any file that calls itself MATLAB's is read, or refused with an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const hymm::core::MatFile file(hymm::test::inputFile(data, size, ".mat"));
    for (const std::string& variable : file.variables()) file.read(variable);
  } catch (const hymm::core::InputError&) {
  }
  return 0;
}
