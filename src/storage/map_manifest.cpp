#include "storage/map_manifest.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <sstream>

#include <xxhash.h>

#include "common/error.h"

namespace hymm::core {
namespace {

constexpr const char* kTitle = "hymm map, format ";
constexpr const char* kSeal = "checksum ";

std::uint64_t checksumOf(const std::string& text) { return XXH3_64bits(text.data(), text.size()); }

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
  throw InputError(name + " is damaged: " + why + ". Use another copy of the map.");
}

/// The text without its last line, which must be the seal that belongs to it.
std::string unsealed(const std::string& text, const std::string& name) {
  const std::size_t seal = text.rfind(kSeal);
  if (seal == std::string::npos) refuse(name, "its last line, a checksum, is missing");
  std::string content = text.substr(0, seal);
  if (text != sealed(content)) refuse(name, "its checksum does not fit");
  return content;
}

template <class Number>
Number numberIn(const std::string& word, int base, const std::string& name) {
  Number number{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number, base);
  if (error != std::errc() || end != word.data() + word.size()) {
    refuse(name, "'" + word + "' is no number");
  }
  return number;
}

/// A name from a file must not lead out of the folder.
bool isPlainName(const std::string& file) {
  return !file.empty() && file.front() != '.' &&
         std::all_of(file.begin(), file.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
         });
}

SavedPart partIn(std::istringstream& line, const std::string& name) {
  SavedPart part;
  std::string bytes, unpacked, checksum;
  line >> part.name >> part.file >> bytes >> unpacked >> checksum;
  part.bytes = numberIn<std::uint64_t>(bytes, 10, name);
  part.unpacked_bytes = numberIn<std::uint64_t>(unpacked, 10, name);
  part.checksum = numberIn<std::uint64_t>(checksum, 16, name);
  if (!isPlainName(part.file)) refuse(name, "'" + part.file + "' is no name of a file");
  return part;
}

void checkTitle(const std::string& text, const std::string& name) {
  if (text.rfind(kTitle, 0) != 0) refuse(name, "it does not begin as a saved map");
  const std::size_t from = std::string(kTitle).size();
  const auto format = numberIn<std::uint32_t>(text.substr(from, text.find('\n') - from), 10, name);
  if (format > MapManifest::kFormat) {
    throw InputError(name + " is of format " + std::to_string(format) +
                     "; this version of hymm reads format " + std::to_string(MapManifest::kFormat) +
                     ". Load the map with the version that saved it, or a later one.");
  }
  if (format != MapManifest::kFormat) refuse(name, "there is no format of this number");
}

}  // namespace

std::string hexOf(std::uint64_t number) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(number));
  return text;
}

const SavedPart* MapManifest::find(const std::string& name) const {
  const auto found = std::find_if(parts.begin(), parts.end(),
                                  [&](const SavedPart& part) { return part.name == name; });
  return found == parts.end() ? nullptr : &*found;
}

std::string textOf(const MapManifest& manifest) {
  std::ostringstream text;
  text << kTitle << MapManifest::kFormat << '\n';
  for (const auto& [key, value] : manifest.notes) text << "note " << key << ' ' << value << '\n';
  text << "landmark_version " << manifest.landmark_version << '\n';
  for (const SavedPart& part : manifest.parts) {
    text << "part " << part.name << ' ' << part.file << ' ' << part.bytes << ' '
         << part.unpacked_bytes << ' ' << hexOf(part.checksum) << '\n';
  }
  return sealed(text.str());
}

std::string sealed(const std::string& text) {
  return text + kSeal + hexOf(checksumOf(text)) + '\n';
}

MapManifest parseManifest(const std::string& text, const std::string& name) {
  const std::string content = unsealed(text, name);
  checkTitle(content, name);
  MapManifest manifest;
  std::istringstream lines(content.substr(content.find('\n') + 1));
  for (std::string line_text; std::getline(lines, line_text);) {
    std::istringstream line(line_text);
    std::string what, word;
    line >> what;
    if (what == "part") {
      manifest.parts.push_back(partIn(line, name));
    } else if (what == "landmark_version") {
      line >> word;
      manifest.landmark_version = numberIn<std::uint64_t>(word, 10, name);
    } else if (what == "note") {
      line >> word;
      std::getline(line >> std::ws, manifest.notes[word]);
    } else {
      refuse(name, "it holds a line '" + what + "' that means nothing");
    }
  }
  return manifest;
}

}  // namespace hymm::core
