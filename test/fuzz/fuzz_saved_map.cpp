#include <algorithm>

#include <zstd.h>

#include "common/error.h"
#include "common/state_archive.h"
#include "fuzz/harness.h"
#include "storage/map_folder.h"

namespace hymm::test {
namespace {

using namespace core;

bool isManifest(const std::string& text) {
  try {
    parseManifest(text, "map.txt");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Four bytes of its unpacked size, the lowest first, and what is packed.
bool isPart(const std::string& input) {
  constexpr std::size_t kMostUnpacked = 1U << 24U;
  std::uint64_t unpacked = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, input.size()); ++i) {
    unpacked |= std::uint64_t{static_cast<unsigned char>(input[i])} << (8 * i);
  }
  if (unpacked > kMostUnpacked) return false;
  try {
    unpackPart(input.substr(std::min<std::size_t>(4, input.size())), unpacked, "part");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

/// The two files of a saved map, as they are on the disk. The seal of the one and the checksum of
/// the other are taken as right, for a fuzzer would never hit them: what comes behind must stand
/// alone.
bool isRead(const std::uint8_t* data, std::size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  const bool is_sealed = isManifest(input);
  const bool is_manifest = isManifest(sealed("hymm map, format 1\n" + input));
  const bool is_part = isPart(input);
  return is_sealed || is_manifest || is_part;
}

std::map<std::string, std::string> seeds() {
  StateWriter archive;
  archive(std::string("landmarks"), SavedSettings{{"a", "1"}}, std::string("state"));
  const std::string& state = archive.bytes();
  std::string packed(ZSTD_compressBound(state.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), state.data(), state.size(), 1));
  const char size[4] = {static_cast<char>(state.size()), 0, 0, 0};
  return {{"part", std::string(size, 4) + packed},
          {"map", "landmark_version 3\nnote saved today\npart landmarks l-1.zst 9 7 1f\n"}};
}

}  // namespace hymm::test
