#pragma once

#include <filesystem>
#include <string>

#include "storage/durable_file.h"
#include "storage/map_manifest.h"
#include "storage/saved_settings.h"

namespace hymm::core {

/// What one owner saves of a map: its state as bytes, and what its configuration said.
struct MapPart {
  static constexpr const char* kLandmarks = "landmarks";  ///< of cekf_slam
  static constexpr const char* kDenseMap = "dense_map";   ///< of hymm_grid

  SavedSettings settings;
  std::string state;
};

/// A folder that holds one saved map. Owners write their parts, each into a file of a new name;
/// then replacing `map.txt` makes them the map, at once, and the files of the map before are
/// removed. So the folder holds the old map or the new one, whole, at every moment; several
/// processes may write parts, one of them completes the map.
///
///   MapFolder folder("/maps/park");
///   manifest.parts = {folder.write(MapPart::kLandmarks, part)};
///   folder.complete(manifest);
///
///   const MapManifest manifest = folder.manifest();   // refuses what is damaged or newer
///   const MapPart part = folder.read(*manifest.find(MapPart::kLandmarks));
class MapFolder {
 public:
  /// Touches nothing. `watch` may be null.
  explicit MapFolder(std::filesystem::path path, DiskWatch* watch = nullptr);

  /// Makes the folder if it is missing (its parent must be there). A folder with anything in it but
  /// a saved map is refused. Throws OutputError.
  void prepare() const;

  /// Writes a part under a name of its own, which nothing reads yet. Throws OutputError.
  SavedPart write(const std::string& name, const MapPart& part) const;

  /// Makes the parts of `manifest` the folder's map, and removes those of the one before. Throws
  /// OutputError; the folder then holds the map that it held.
  void complete(const MapManifest& manifest) const;

  /// The folder's map; its parts are there and as long as they were. Throws InputError.
  MapManifest manifest() const;

  /// A part, unpacked. Throws InputError if a bit of it is not as it was written.
  MapPart read(const SavedPart& part) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  void removeOthers(const MapManifest& manifest) const;

  std::filesystem::path path_;
  DiskWatch* watch_;
};

/// The part in a file's content, of which the checksum was found right. `name` leads the sentences.
/// Throws InputError. For MapFolder, and for tests with content that no program has written.
MapPart unpackPart(const std::string& content, std::uint64_t unpacked_bytes,
                   const std::string& name);

}  // namespace hymm::core
