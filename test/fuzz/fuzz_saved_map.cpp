#include <algorithm>
#include <string>

#include <zstd.h>

#include "common/error.h"
#include "common/state_archive.h"
#include "input_file.h"
#include "storage/map_folder.h"

/// Something to begin with.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  hymm::core::StateWriter archive;
  archive(std::string("landmarks"), hymm::core::SavedSettings{{"a", "1"}}, std::string("state"));
  std::string packed(ZSTD_compressBound(archive.bytes().size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), archive.bytes().data(),
                              archive.bytes().size(), 1));
  const char size[4] = {static_cast<char>(archive.bytes().size()), 0, 0, 0};
  hymm::test::writeSeed("part", std::string(size, 4) + packed);
  hymm::test::writeSeed("map",
                        "landmark_version 3\nnote saved today\npart landmarks l-1.zst 9 7 1f\n");
  return 0;
}

/// The two files of a saved map, as they are on the disk. The seal of the one and the checksum of
/// the other are taken as right, for a fuzzer would never hit them: what comes behind must stand
/// alone.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostUnpacked = 1U << 24U;
  const std::string input(reinterpret_cast<const char*>(data), size);
  using namespace hymm::core;
  for (const std::string& text : {input, sealed("hymm map, format 1\n" + input)}) {
    try {
      parseManifest(text, "map.txt");
    } catch (const InputError&) {
    }
  }
  try {
    std::uint64_t unpacked = 0;
    for (std::size_t i = 0; i < 4 && i < size; ++i) unpacked |= std::uint64_t{data[i]} << (8 * i);
    if (unpacked <= kMostUnpacked)
      unpackPart(input.substr(std::min<std::size_t>(4, size)), unpacked, "part");
  } catch (const InputError&) {
  }
  return 0;
}
