#pragma once

#include <string>

#include <hymm/LoadState.h>
#include <hymm/SaveState.h>

#include "storage/map_folder.h"

namespace hymm {

/// Writes a part of a map as the request says, and tells of it; a failure becomes the response's
/// message.
void writePart(const std::string& folder, const std::string& name, const core::MapPart& part,
               SaveState::Response& response);

/// A part of the map in a folder, with the name that leads sentences about it. Throws InputError if
/// it is damaged, or not there.
struct NamedPart {
  std::string name;
  core::MapPart part;
};
NamedPart readPart(const std::string& folder, const std::string& name);

}  // namespace hymm
