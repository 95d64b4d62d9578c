#include <cstdlib>

#include "fuzz/harness.h"

/// Writes the seeds into the folder $HYMM_FUZZ_SEEDS, if that is set.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  if (const char* folder = std::getenv("HYMM_FUZZ_SEEDS")) {
    for (const auto& [name, content] : hymm::test::seeds()) {
      std::ofstream(std::filesystem::path(folder) / name, std::ios::binary) << content;
    }
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hymm::test::isRead(data, size);
  return 0;
}
