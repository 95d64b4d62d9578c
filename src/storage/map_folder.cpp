#include "storage/map_folder.h"

#include <algorithm>
#include <fstream>
#include <memory>
#include <regex>
#include <utility>
#include <vector>

#include <xxhash.h>
#include <zstd.h>

#include "common/error.h"
#include "common/state_archive.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

// Covariances hardly compress, so that more work is not worth it.
constexpr int kLevel = 1;
constexpr std::size_t kPiece = std::size_t{1} << 20U;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};
struct FreeHash {
  void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

/// Compresses `content` into a file, piece by piece.
class PackedFile {
 public:
  PackedFile(DurableFile& file, std::size_t size)
      : file_(file), context_(ZSTD_createCCtx()), hash_(XXH3_createState()) {
    if (!context_ || !hash_) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kLevel);
    ZSTD_CCtx_setPledgedSrcSize(context_.get(), size);
    XXH3_64bits_reset(hash_.get());
  }

  void add(std::string_view content) {
    std::vector<char> packed(ZSTD_CStreamOutSize());
    bool done = false;
    for (std::size_t at = 0; !done;) {
      const std::size_t size = std::min(kPiece, content.size() - at);
      const bool is_last = at + size == content.size();
      ZSTD_inBuffer input{content.data() + at, size, 0};
      do {
        ZSTD_outBuffer output{packed.data(), packed.size(), 0};
        const std::size_t left = ZSTD_compressStream2(context_.get(), &output, &input,
                                                      is_last ? ZSTD_e_end : ZSTD_e_continue);
        if (ZSTD_isError(left) != 0) throw OutputError("zstd cannot compress the map.");
        file_.write(packed.data(), output.pos);
        XXH3_64bits_update(hash_.get(), packed.data(), output.pos);
        bytes_ += output.pos;
        done = is_last && left == 0;
      } while (is_last ? !done : input.pos < input.size);
      at += size;
    }
  }

  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t checksum() const { return XXH3_64bits_digest(hash_.get()); }

 private:
  DurableFile& file_;
  std::unique_ptr<ZSTD_CCtx, FreeContext> context_;
  std::unique_ptr<XXH3_state_t, FreeHash> hash_;
  std::uint64_t bytes_ = 0;
};

/// Files that this program writes into such a folder, finished or not.
bool isOurs(const std::string& file) {
  static const std::regex ours(
      R"((map\.txt|[a-z_]+-[0-9a-f]{16}\.zst)(\.active)?|[a-z_]+\.active)");
  return std::regex_match(file, ours);
}

std::string contentOf(const fs::path& path, const std::string& instead) {
  std::ifstream file(path, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) throw InputError(path.string() + " cannot be read; " + instead);
  return content;
}

}  // namespace

MapFolder::MapFolder(fs::path path, DiskWatch* watch) : path_(std::move(path)), watch_(watch) {}

void MapFolder::prepare() const {
  std::error_code error;
  if (!fs::exists(path_, error)) {
    if (watch_ != nullptr) watch_->before("make folder");
    fs::create_directory(path_, error);
  }
  if (!fs::is_directory(path_, error)) {
    throw OutputError(path_.string() +
                      " cannot be made; name a folder in one that exists and can be written to.");
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(path_)) {
    if (isOurs(entry.path().filename().string())) continue;
    throw OutputError(path_.string() + " holds " + entry.path().filename().string() +
                      ", which is no part of a map; name a folder of its own for the map.");
  }
}

SavedPart MapFolder::write(const std::string& name, const MapPart& part) const {
  StateWriter archive;
  archive(name, part.settings, part.state);
  SavedPart saved;
  saved.name = name;
  saved.unpacked_bytes = archive.bytes().size();
  DurableFile file(path_, watch_);
  file.open(name);
  PackedFile packed(file, archive.bytes().size());
  packed.add(archive.bytes());
  saved.bytes = packed.bytes();
  saved.checksum = packed.checksum();
  saved.file = name + "-" + hexOf(saved.checksum) + ".zst";
  file.complete(saved.file);
  return saved;
}

void MapFolder::complete(const MapManifest& manifest) const {
  const std::string text = textOf(manifest);
  DurableFile file(path_, watch_);
  file.open(MapManifest::kFile);
  file.write(text.data(), text.size());
  file.complete(MapManifest::kFile);
  removeOthers(manifest);
}

void MapFolder::removeOthers(const MapManifest& manifest) const {
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_)) {
    const std::string name = entry.path().filename().string();
    const bool is_part = std::any_of(manifest.parts.begin(), manifest.parts.end(),
                                     [&](const SavedPart& part) { return part.file == name; });
    if (!is_part && name != MapManifest::kFile && isOurs(name)) others.push_back(entry.path());
  }
  for (const fs::path& other : others) removeDurably(other, watch_);
}

MapManifest MapFolder::manifest() const {
  const fs::path file = path_ / MapManifest::kFile;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    throw InputError(path_.string() + " holds no saved map: there is no file " +
                     MapManifest::kFile + " in it.");
  }
  const MapManifest manifest =
      parseManifest(contentOf(file, "check its permissions."), file.string());
  for (const SavedPart& part : manifest.parts) {
    const fs::path place = path_ / part.file;
    const std::uintmax_t bytes = fs::file_size(place, error);
    if (error) throw InputError(place.string() + ", a part of the map, is missing or hidden.");
    if (bytes == part.bytes) continue;
    throw InputError(place.string() + " is damaged: it has " + std::to_string(bytes) + " of " +
                     std::to_string(part.bytes) + " bytes. Use another copy of the map.");
  }
  return manifest;
}

MapPart MapFolder::read(const SavedPart& part) const {
  const fs::path place = path_ / part.file;
  const std::string content = contentOf(place, "it is a part of the map.");
  const bool is_same =
      content.size() == part.bytes && XXH3_64bits(content.data(), content.size()) == part.checksum;
  if (!is_same) {
    throw InputError(place.string() +
                     " is damaged: its checksum does not fit. Use another copy of the map.");
  }
  return unpackPart(content, part.unpacked_bytes, place.string());
}

MapPart unpackPart(const std::string& content, std::uint64_t unpacked_bytes,
                   const std::string& name) {
  const bool is_told = ZSTD_getFrameContentSize(content.data(), content.size()) == unpacked_bytes;
  if (!is_told) throw InputError(name + " is damaged: it is not as long as it should be.");
  std::string bytes(unpacked_bytes, '\0');
  const std::size_t size =
      ZSTD_decompress(bytes.data(), bytes.size(), content.data(), content.size());
  if (ZSTD_isError(size) != 0 || size != bytes.size()) {
    throw InputError(name + " is damaged: zstd cannot unpack it. Use another copy of the map.");
  }
  StateReader archive(bytes, name);
  std::string part_name;
  MapPart part;
  archive(part_name, part.settings, part.state);
  archive.requireEnd();
  return part;
}

}  // namespace hymm::core
