#include "ros/bag_structure.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace hymm {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
// The largest chunk that is believed. Recorders close one after 768 KB and the message within.
constexpr std::uint32_t kLargestChunk_bytes = 1U << 30U;

enum Kind : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

/// A file as memory, read as it is looked at.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path) : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    struct stat status {};
    if (file_ < 0 || ::fstat(file_, &status) != 0) return;
    size_ = static_cast<std::size_t>(status.st_size);
    void* content =
        size_ == 0 ? MAP_FAILED : ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file_, 0);
    if (content != MAP_FAILED) content_ = static_cast<const char*>(content);
  }
  ~MappedFile() {
    if (content_ != nullptr) ::munmap(const_cast<char*>(content_), size_);
    if (file_ >= 0) ::close(file_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::string_view content() const {
    return content_ == nullptr ? std::string_view() : std::string_view(content_, size_);
  }

 private:
  int file_;
  std::size_t size_ = 0;
  const char* content_ = nullptr;
};

[[noreturn]] void refuse(const std::string& what, std::uint64_t at) {
  throw std::runtime_error(what + " at byte " + std::to_string(at));
}

/// Takes a length of four bytes and as many bytes as it tells from the front of `bytes`; none if
/// there are not as many.
std::optional<std::string_view> takeCounted(std::string_view& bytes) {
  std::uint32_t length = 0;
  if (bytes.size() < sizeof(length)) return std::nullopt;
  std::memcpy(&length, bytes.data(), sizeof(length));
  bytes.remove_prefix(sizeof(length));
  if (bytes.size() < length) return std::nullopt;
  const std::string_view taken = bytes.substr(0, length);
  bytes.remove_prefix(length);
  return taken;
}

using Fields = std::map<std::string_view, std::string_view>;

Fields fieldsOf(std::string_view header, std::uint64_t at) {
  Fields fields;
  while (!header.empty()) {
    const auto field = takeCounted(header);
    if (!field) refuse("a field is longer than its record", at);
    const std::size_t equals = field->find('=');
    if (equals == std::string_view::npos) refuse("a field has no name", at);
    fields[field->substr(0, equals)] = field->substr(equals + 1);
  }
  return fields;
}

struct Record {
  std::uint64_t at = 0;
  std::uint64_t end = 0;
  Fields fields;
  std::string_view data;

  template <class Number>
  Number number(std::string_view name) const {
    static_assert(std::is_integral_v<Number>);
    const auto field = fields.find(name);
    Number number{};
    if (field == fields.end() || field->second.size() != sizeof(number))
      refuse("the field '" + std::string(name) + "' is missing or of another length", at);
    std::memcpy(&number, field->second.data(), sizeof(number));
    return number;
  }
  std::uint8_t kind() const { return number<std::uint8_t>("op"); }
};

/// The record at a place in `bytes`, all of which lies in it.
Record recordAt(std::string_view bytes, std::uint64_t at) {
  std::string_view rest = bytes.substr(at);
  Record record;
  record.at = at;
  const auto header = takeCounted(rest);
  const auto data = header ? takeCounted(rest) : std::nullopt;
  if (!data) refuse("a record is longer than what holds it", at);
  record.fields = fieldsOf(*header, at);
  record.data = *data;
  record.end = bytes.size() - rest.size();
  return record;
}

/// Indices lead into a chunk that is not compressed at these places.
std::set<std::uint64_t> messagesIn(std::string_view chunk) {
  std::set<std::uint64_t> places;
  for (std::uint64_t at = 0; at < chunk.size();) {
    const Record record = recordAt(chunk, at);
    if (record.kind() == kMessage) places.insert(at);
    if (record.kind() == kConnection) fieldsOf(record.data, at);
    at = record.end;
  }
  return places;
}

class BagWalk {
 public:
  explicit BagWalk(std::string_view bytes) : bytes_(bytes) {}

  void check() {
    const Record header = recordAt(bytes_, kMagic.size());
    if (header.kind() != kBagHeader) refuse("the first record is not that of a bag", header.at);
    const auto index_at = header.number<std::uint64_t>("index_pos");
    if (index_at == 0) return;
    std::uint64_t at = checkChunks(header.end, index_at);
    at = checkConnections(at, header.number<std::uint32_t>("conn_count"));
    checkChunkInfos(at, header.number<std::uint32_t>("chunk_count"));
  }

 private:
  /// The number of indices behind each chunk is kept. Returns where the index of the bag begins.
  std::uint64_t checkChunks(std::uint64_t at, std::uint64_t index_at) {
    if (index_at > bytes_.size()) {
      throw BagCutOff("its index is said to begin at byte " + std::to_string(index_at) + " of " +
                      std::to_string(bytes_.size()));
    }
    while (at < index_at) {
      const Record chunk = recordAt(bytes_, at);
      at = chunk.kind() == kChunk ? checkChunk(chunk) : chunk.end;
    }
    if (at != index_at) refuse("no record begins where the index is said to be,", index_at);
    return at;
  }

  std::uint64_t checkChunk(const Record& chunk) {
    const auto size = chunk.number<std::uint32_t>("size");
    const auto compression = chunk.fields.find("compression");
    const bool is_plain = compression != chunk.fields.end() && compression->second == "none";
    if (size > kLargestChunk_bytes || (is_plain && size != chunk.data.size()))
      refuse("a chunk is not as large as it claims,", chunk.at);
    std::set<std::uint64_t> messages;
    if (is_plain) messages = messagesIn(chunk.data);
    std::uint32_t& indices = indices_[chunk.at];
    std::uint64_t at = chunk.end;
    while (at < bytes_.size()) {
      const Record index = recordAt(bytes_, at);
      if (index.kind() != kIndex) break;
      checkIndex(index, size, is_plain ? &messages : nullptr);
      ++indices;
      at = index.end;
    }
    return at;
  }

  static void checkIndex(const Record& index, std::uint32_t chunk_bytes,
                         const std::set<std::uint64_t>* messages) {
    constexpr std::size_t kEntry_bytes = 12;  // time, place
    const auto count = index.number<std::uint32_t>("count");
    if (index.data.size() != count * kEntry_bytes)
      refuse("an index has another length than it tells", index.at);
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t place = 0;
      std::memcpy(&place, index.data.data() + i * kEntry_bytes + 8, sizeof(place));
      if (messages != nullptr ? messages->count(place) == 0 : place >= chunk_bytes)
        refuse("an index leads to no message", index.at);
    }
  }

  std::uint64_t checkConnections(std::uint64_t at, std::uint32_t count) const {
    for (std::uint32_t i = 0; i < count; ++i) {
      const Record record = recordAt(bytes_, at);
      if (record.kind() != kConnection) refuse("a connection is missing", at);
      fieldsOf(record.data, at);
      at = record.end;
    }
    return at;
  }

  void checkChunkInfos(std::uint64_t at, std::uint32_t count) const {
    constexpr std::size_t kCount_bytes = 8;  // connection, number of messages
    for (std::uint32_t i = 0; i < count; ++i) {
      const Record record = recordAt(bytes_, at);
      if (record.kind() != kChunkInfo) refuse("the description of a chunk is missing", at);
      const auto connections = record.number<std::uint32_t>("count");
      const auto chunk = indices_.find(record.number<std::uint64_t>("chunk_pos"));
      if (record.data.size() != connections * kCount_bytes || chunk == indices_.end() ||
          connections > chunk->second) {
        refuse("the description of a chunk does not fit it", at);
      }
      at = record.end;
    }
  }

  std::string_view bytes_;
  std::map<std::uint64_t, std::uint32_t> indices_;  ///< behind each chunk, by its place
};

}  // namespace

void checkBagStructure(const std::string& path) {
  const MappedFile file(path);
  const std::string_view content = file.content();
  if (content.substr(0, kMagic.size()) != kMagic) {
    if (!content.empty() && kMagic.substr(0, content.size()) == content)
      throw BagCutOff("it has " + std::to_string(content.size()) + " bytes");
    throw NotABag("it does not begin as bags of version 2.0 do");
  }
  BagWalk(content).check();
}

}  // namespace hymm
