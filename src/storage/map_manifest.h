#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace hymm::core {

/// A part of a saved map: one file of the folder.
struct SavedPart {
  std::string name;  ///< `landmarks`, `dense_map`
  std::string file;  ///< NAME-CHECKSUM.zst: another content has another name
  std::uint64_t bytes = 0;
  std::uint64_t unpacked_bytes = 0;
  std::uint64_t checksum = 0;  ///< XXH3, 64 bits, of the file as it is
};

/// What a saved map consists of. The folder's file `map.txt`, which is replaced last, holds it: the
/// parts that it names are the map, and whatever else lies in the folder is not.
struct MapManifest {
  /// Grows when older programs cannot read what newer ones write.
  static constexpr std::uint32_t kFormat = 1;
  static constexpr const char* kFile = "map.txt";

  std::uint64_t landmark_version = 0;        ///< of the landmarks, in all parts
  std::map<std::string, std::string> notes;  ///< for people: when, by what, how large
  std::vector<SavedPart> parts;

  const SavedPart* find(const std::string& name) const;
};

/// As `map.txt` has it, with a checksum in its last line.
std::string textOf(const MapManifest& manifest);

/// A text with the last line that seals it. Every format, also to come, begins and ends in this
/// way, so that what is newer is told from what is damaged.
std::string sealed(const std::string& text);

/// Throws InputError, with a sentence led by `name`, if the text is damaged or of a newer format.
MapManifest parseManifest(const std::string& text, const std::string& name);

std::string hexOf(std::uint64_t number);

}  // namespace hymm::core
