#include "ros/map_part.h"

#include <exception>
#include <filesystem>

#include "common/error.h"

namespace hymm {

void writePart(const std::string& folder, const std::string& name, const core::MapPart& part,
               SaveState::Response& response) {
  try {
    const core::SavedPart saved = core::MapFolder(folder).write(name, part);
    response.name = saved.name;
    response.file = saved.file;
    response.bytes = saved.bytes;
    response.unpacked_bytes = saved.unpacked_bytes;
    response.checksum = saved.checksum;
    response.success = true;
  } catch (const std::exception& error) {
    response.message = error.what();
  }
}

NamedPart readPart(const std::string& folder, const std::string& name) {
  const core::MapFolder map(folder);
  const core::MapManifest manifest = map.manifest();
  const core::SavedPart* part = manifest.find(name);
  if (part == nullptr) throw core::InputError(folder + " holds no part '" + name + "'.");
  return {(std::filesystem::path(folder) / part->file).string(), map.read(*part)};
}

}  // namespace hymm
