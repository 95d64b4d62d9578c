#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <unistd.h>

/// What each fuzzer defines, for a reader of files. libFuzzer comes in by entry.cpp; a unit test
/// feeds the seeds to the same functions, so that no fuzzer breaks unseen.
namespace hymm::test {

/// Whether the input was read; if not, it was refused with an InputError. All else is a finding.
bool isRead(const std::uint8_t* data, std::size_t size);

/// Inputs to begin with, by name. All of them are read.
std::map<std::string, std::string> seeds();

/// A file in memory-backed storage that holds one input, for readers that take paths.
inline std::string inputFile(const std::uint8_t* data, std::size_t size, const char* extension) {
  static const struct Place {
    std::string path;
    ~Place() { std::remove(path.c_str()); }
  } place{"/dev/shm/hymm_fuzz_" + std::to_string(::getpid()) + extension};
  std::ofstream file(place.path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return place.path;
}

}  // namespace hymm::test
