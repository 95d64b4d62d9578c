#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include <zip.h>

namespace hymm::test {

/// Packs files, by name in the archive, into a .zip; `method` is one of libzip's.
inline void writeArchive(const std::filesystem::path& path,
                         const std::map<std::string, std::string>& files,
                         zip_int32_t method = ZIP_CM_DEFAULT) {
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) throw std::runtime_error("cannot make an archive");
  for (const auto& [name, content] : files) {
    zip_source_t* source = zip_source_buffer(archive, content.data(), content.size(), 0);
    const zip_int64_t index = zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0 ||
        zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), method, 0) != 0) {
      throw std::runtime_error("cannot pack " + name);
    }
  }
  if (zip_close(archive) != 0) throw std::runtime_error("cannot write the archive");
}

}  // namespace hymm::test
