#include "datasets/mat_structure.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <zlib.h>

#include "common/error.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

constexpr char kDamaged[] = "; the file is cut off or damaged, get it again.";
constexpr std::uint32_t kLongestName_bytes = 1024;  // MATLAB itself allows 63

[[noreturn]] void refuseAsCutOff(const fs::path& path, std::uint64_t size) {
  throw InputError(path.string() + " ends after " + std::to_string(size) +
                   " bytes, within a variable" + kDamaged);
}

[[noreturn]] void refuseAsDamaged(const fs::path& path, std::uint64_t at) {
  throw InputError(path.string() + ": the variable at byte " + std::to_string(at) +
                   " is no plain matrix, or is damaged; save the file anew, with matrices of"
                   " numbers alone.");
}

/// The type and length that an element of a version 5 file begins with.
using Tag = std::array<std::uint32_t, 2>;
constexpr std::uint64_t kTag_bytes = sizeof(Tag);
constexpr std::uint32_t kMatrix = 14, kCompressed = 15;

// What an array begins with, behind its tag: flags, tag of the dimensions, these, tag of the name.
constexpr std::size_t kArrayHeader_bytes = 16 + 8 + 8 + 8;

/// Whether an array of two dimensions begins at `header`. Structures, cells and objects, which hold
/// lengths within lengths, are none.
bool isPlainArray(const std::array<unsigned char, kArrayHeader_bytes>& header) {
  std::array<std::uint32_t, kArrayHeader_bytes / 4> words{};
  std::memcpy(words.data(), header.data(), header.size());
  constexpr std::uint32_t kFlags = 6, kInteger = 5, kName = 1, kText = 4, kLargestNumber = 15;
  const std::uint32_t type = words[2] & 0xffU;
  const bool is_small_name = words[8] >> 16U != 0;  // up to four bytes stand in the tag itself
  return words[0] == kFlags && words[1] == 8 && type >= kText && type <= kLargestNumber &&
         words[4] == kInteger && words[5] == 8 && (words[8] & 0xffffU) == kName &&
         (is_small_name ? words[8] >> 16U <= 4 : words[9] <= kLongestName_bytes);
}

/// Unpacks bytes of zlib as they come, keeps what the array begins with, and sees whether the
/// checksum at the end is right.
class Inflation {
 public:
  Inflation() { is_right_ = inflateInit(&stream_) == Z_OK; }
  ~Inflation() { inflateEnd(&stream_); }
  Inflation(const Inflation&) = delete;
  Inflation& operator=(const Inflation&) = delete;

  void add(std::vector<char>& packed) {
    stream_.next_in = reinterpret_cast<unsigned char*>(packed.data());
    stream_.avail_in = static_cast<unsigned>(packed.size());
    do {
      stream_.next_out = unpacked_.data();
      stream_.avail_out = static_cast<unsigned>(unpacked_.size());
      const int answer = is_right_ && !is_complete_ ? inflate(&stream_, Z_NO_FLUSH) : Z_OK;
      is_complete_ = is_complete_ || answer == Z_STREAM_END;
      is_right_ = is_right_ && (answer == Z_OK || answer == Z_STREAM_END || answer == Z_BUF_ERROR);
      keep(unpacked_.size() - stream_.avail_out);
    } while (is_right_ && !is_complete_ && stream_.avail_out == 0);
  }

  bool holdsPlainArray() const {
    Tag tag{};
    std::memcpy(tag.data(), begin_.data(), kTag_bytes);
    std::array<unsigned char, kArrayHeader_bytes> header{};
    std::memcpy(header.data(), begin_.data() + kTag_bytes, header.size());
    return is_right_ && is_complete_ && tag[0] == kMatrix && tag[1] + kTag_bytes == total_ &&
           isPlainArray(header);
  }

 private:
  void keep(std::size_t count) {
    if (total_ < begin_.size()) {
      const auto kept = std::min(count, begin_.size() - static_cast<std::size_t>(total_));
      std::memcpy(begin_.data() + total_, unpacked_.data(), kept);
    }
    total_ += count;
  }

  z_stream stream_{};
  bool is_right_ = false, is_complete_ = false;
  std::uint64_t total_ = 0;
  std::array<unsigned char, kTag_bytes + kArrayHeader_bytes> begin_{};
  std::array<unsigned char, 1U << 16U> unpacked_{};
};

bool isCompressedPlainArray(std::ifstream& stream, std::uint32_t bytes) {
  Inflation inflation;
  for (std::uint32_t left = bytes; left > 0;) {
    std::vector<char> packed(std::min(left, 1U << 16U));
    stream.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    inflation.add(packed);
    left -= static_cast<std::uint32_t>(packed.size());
  }
  return inflation.holdsPlainArray();
}

/// A header of 128 bytes and then elements, which must end where the file does.
void checkVersion5(std::ifstream& stream, const fs::path& path, std::uint64_t size) {
  for (std::uint64_t at = 128; at < size;) {
    Tag tag{};
    stream.seekg(static_cast<std::streamoff>(at));
    stream.read(reinterpret_cast<char*>(tag.data()), kTag_bytes);
    if (!stream || at + kTag_bytes + tag[1] > size) refuseAsCutOff(path, size);
    if (tag[0] == kMatrix) {
      std::array<unsigned char, kArrayHeader_bytes> header{};
      if (tag[1] >= header.size())
        stream.read(reinterpret_cast<char*>(header.data()), header.size());
      if (!isPlainArray(header)) refuseAsDamaged(path, at);
    } else if (tag[0] != kCompressed || !isCompressedPlainArray(stream, tag[1])) {
      refuseAsDamaged(path, at);
    }
    at += kTag_bytes + tag[1];
  }
}

std::uint32_t otherByteOrder(std::uint32_t word) {
  return word << 24U | (word & 0xff00U) << 8U | (word >> 8U & 0xff00U) | word >> 24U;
}

/// A file of version 4 is a row of variables: five words, the name, the numbers.
void checkVersion4(std::ifstream& stream, const fs::path& path, std::uint64_t size) {
  constexpr std::array<std::uint64_t, 6> kNumber_bytes = {8, 4, 4, 2, 2, 1};  // by the type's tens
  constexpr std::uint32_t kLargestType = 4052;
  for (std::uint64_t at = 0; at < size;) {
    std::array<std::uint32_t, 5> words{};  // type, rows, columns, is it complex, bytes of the name
    stream.seekg(static_cast<std::streamoff>(at));
    stream.read(reinterpret_cast<char*>(words.data()), sizeof(words));
    if (!stream) refuseAsCutOff(path, size);
    if (words[0] > kLargestType) {
      for (std::uint32_t& word : words) word = otherByteOrder(word);
    }
    const auto [type, rows, columns, is_complex, name_bytes] = words;
    const std::size_t number = type / 10 % 10;
    if (type > kLargestType || number >= kNumber_bytes.size() || name_bytes > kLongestName_bytes) {
      throw InputError(path.string() +
                       " is not a MATLAB file, or its beginning is damaged; give a"
                       " .mat file as MATLAB saves it.");
    }
    const double numbers = (is_complex == 0 ? 1.0 : 2.0) * rows * columns;
    const double left = static_cast<double>(size - at) - sizeof(words) - name_bytes;
    if (numbers * static_cast<double>(kNumber_bytes[number]) > left) refuseAsCutOff(path, size);
    at += sizeof(words) + name_bytes + static_cast<std::uint64_t>(numbers) * kNumber_bytes[number];
  }
}

}  // namespace

void checkMatStructure(const fs::path& path) {
  const std::uint64_t size = fs::file_size(path);
  std::ifstream stream(path, std::ios::binary);
  std::array<char, 128> header{};
  stream.read(header.data(), header.size());
  const bool is_version_4 = size < header.size() || std::memcmp(header.data(), "MATLAB", 6) != 0;
  stream.clear();
  if (is_version_4) return checkVersion4(stream, path, size);
  constexpr char kVersion[] = "\0\1IM";  // and the byte order
  if (std::memcmp(header.data(), "MATLAB 5.0", 10) != 0 ||
      std::memcmp(header.data() + 124, kVersion, 4) != 0) {
    throw InputError(path.string() +
                     " is not of MATLAB's version 5 or 7 (or of another byte order); save it anew,"
                     " with '-v7'.");
  }
  checkVersion5(stream, path, size);
}

}  // namespace hymm::core
