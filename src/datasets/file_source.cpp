#include "datasets/file_source.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <memory>
#include <sstream>

#include <zip.h>

#include "common/error.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

// No file of these recordings is near this; a size beyond it is a damaged directory.
constexpr zip_uint64_t kLargestMember_bytes = zip_uint64_t{1} << 30;

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct CloseMember {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

std::unique_ptr<zip_t, CloseArchive> openArchive(const fs::path& path) {
  int code = 0;
  std::unique_ptr<zip_t, CloseArchive> archive(
      zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code));
  if (!archive) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string cause = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw InputError(path.string() + " cannot be read as a .zip archive (" + cause +
                     "): it is damaged, cut off, or something else; download it again.");
  }
  return archive;
}

}  // namespace

FileSource::FileSource(const fs::path& path) : path_(path) {
  if (!fs::exists(path)) {
    throw InputError(path.string() + " does not exist; check the path.");
  }
  is_archive_ = !fs::is_directory(path);
  is_archive_ ? listArchive() : listFolder();
}

void FileSource::listFolder() {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().filename().string();
    members_.emplace(lowerCase(name), name);
  }
  if (error) {
    throw InputError(path_.string() + " cannot be listed (" + error.message() +
                     "); check its permissions.");
  }
}

void FileSource::listArchive() {
  const auto archive = openArchive(path_);
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* member = zip_get_name(archive.get(), static_cast<zip_uint64_t>(i), 0);
    if (member == nullptr) continue;
    const std::string name = fs::path(member).filename().string();
    if (!name.empty()) members_.emplace(lowerCase(name), member);
  }
}

bool FileSource::contains(const std::string& name) const {
  return members_.count(lowerCase(name)) > 0;
}

std::string FileSource::origin(const std::string& name) const {
  return is_archive_ ? path_.string() + ": " + name : (path_ / name).string();
}

std::string FileSource::read(const std::string& name) const {
  const auto [first, last] = members_.equal_range(lowerCase(name));
  if (first == last) {
    throw InputError(path_.string() + " holds no file " + name +
                     "; give the complete recording, as it was published.");
  }
  if (std::next(first) != last) {
    throw InputError(path_.string() + " holds more than one file " + name +
                     "; extract it and give the folder of one recording.");
  }
  return is_archive_ ? readFromArchive(first->second, origin(name))
                     : readFile(path_ / first->second);
}

std::string FileSource::readFromArchive(const std::string& member,
                                        const std::string& origin) const {
  const auto fail = [&](const std::string& cause) {
    throw InputError(origin + " cannot be unpacked (" + cause +
                     "): the archive is damaged; download it again.");
  };
  const auto archive = openArchive(path_);
  zip_stat_t stat;
  if (zip_stat(archive.get(), member.c_str(), 0, &stat) != 0) fail(zip_strerror(archive.get()));
  if (stat.size > kLargestMember_bytes) fail("it claims to be larger than 1 GiB");
  const std::unique_ptr<zip_file_t, CloseMember> file(zip_fopen(archive.get(), member.c_str(), 0));
  if (!file) fail(zip_strerror(archive.get()));

  // One byte more than there should be: the checksum is verified on reading the end.
  std::string content(static_cast<std::size_t>(stat.size) + 1, '\0');
  std::size_t size = 0;
  while (size < content.size()) {
    const zip_int64_t got = zip_fread(file.get(), content.data() + size, content.size() - size);
    if (got < 0) fail(zip_file_strerror(file.get()));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size != stat.size) fail("its length differs from the directory's");
  content.resize(size);
  return content;
}

std::string readFile(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream content;
  if (stream) content << stream.rdbuf();
  // An empty file sets the fail bit of `content`; only the stream itself tells of bad reads.
  if (!stream.is_open() || stream.bad()) {
    throw InputError(path.string() + " cannot be read; check that it exists and is readable.");
  }
  return content.str();
}

}  // namespace hymm::core
