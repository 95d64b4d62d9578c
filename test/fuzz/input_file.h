#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace hymm::test {

/// A file in memory-backed storage that holds one input of the fuzzer, for readers that take paths.
inline std::string inputFile(const std::uint8_t* data, std::size_t size, const char* extension) {
  static const std::string path = "/dev/shm/hymm_fuzz_" + std::to_string(::getpid()) + extension;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path;
}

/// Writes a file to begin with into the folder $HYMM_FUZZ_SEEDS, if that is set.
inline void writeSeed(const std::string& name, const std::string& content) {
  const char* folder = std::getenv("HYMM_FUZZ_SEEDS");
  if (folder != nullptr)
    std::ofstream(std::filesystem::path(folder) / name, std::ios::binary) << content;
}

}  // namespace hymm::test
