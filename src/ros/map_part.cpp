#include "ros/map_part.h"

#include <exception>
#include <filesystem>

#include <ros/init.h>

#include "common/error.h"

namespace hymm {
namespace {

/// Breaks off the writing of a part when the node is to end: a large one takes longer than that
/// may. The map before stays; what was begun is removed.
class NodeWatch : public core::DiskWatch {
 public:
  void before(const std::string& step) override {
    const bool tidies_up = step.rfind("remove", 0) == 0;
    if (ros::isShuttingDown() && !tidies_up) {
      throw core::OutputError("The node ends; the map is not saved.");
    }
  }
};

}  // namespace

void writePart(const std::string& folder, const std::string& name, const core::MapPart& part,
               SaveState::Response& response) {
  try {
    NodeWatch watch;
    const core::SavedPart saved = core::MapFolder(folder, &watch).write(name, part);
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
