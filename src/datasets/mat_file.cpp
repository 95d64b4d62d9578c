#include "datasets/mat_file.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <matio.h>

#include "common/error.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

constexpr char kDamaged[] = "; the file is cut off or damaged, get it again.";

struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

std::string listOf(const std::set<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

[[noreturn]] void refuseAsCutOff(const fs::path& path, std::uint64_t size) {
  throw InputError(path.string() + " ends after " + std::to_string(size) +
                   " bytes, within a variable" + kDamaged);
}

/// matio reads what is left of a version 5 file that was cut off, without a word. Such a file is a
/// header of 128 bytes and then elements that each tell their length: they must end where the file
/// does.
void refuseCutOffVersion5(std::ifstream& stream, const fs::path& path, std::uint64_t size) {
  constexpr std::uint64_t kHeader_bytes = 128, kTag_bytes = 8;
  std::uint64_t at = kHeader_bytes;
  while (at < size) {
    std::array<std::uint32_t, 2> tag{};  // type, length
    stream.seekg(static_cast<std::streamoff>(at));
    stream.read(reinterpret_cast<char*>(tag.data()), kTag_bytes);
    if (!stream || at + kTag_bytes + tag[1] > size) refuseAsCutOff(path, size);
    at += kTag_bytes + tag[1];
  }
}

std::uint32_t otherByteOrder(std::uint32_t word) {
  return word << 24U | (word & 0xff00U) << 8U | (word >> 8U & 0xff00U) | word >> 24U;
}

/// A file of version 4 is a row of variables: five words, the name, the numbers. matio takes memory
/// for whatever these words tell.
void refuseCutOffVersion4(std::ifstream& stream, const fs::path& path, std::uint64_t size) {
  constexpr std::array<std::uint64_t, 6> kNumber_bytes = {8, 4, 4, 2, 2, 1};  // by the type's tens
  constexpr std::uint32_t kLargestType = 4052, kLongestName_bytes = 1024;
  std::uint64_t at = 0;
  while (at < size) {
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

/// Before matio believes what the file tells of itself.
void refuseIfCutOff(const fs::path& path) {
  const std::uint64_t size = fs::file_size(path);
  std::ifstream stream(path, std::ios::binary);
  std::array<char, 128> header{};
  stream.read(header.data(), header.size());
  const bool is_version_4 = size < header.size() || std::memcmp(header.data(), "MATLAB", 6) != 0;
  stream.clear();
  if (is_version_4) return refuseCutOffVersion4(stream, path, size);
  if (std::memcmp(header.data(), "MATLAB 5.0", 10) != 0) return;
  if (std::memcmp(header.data() + 126, "IM", 2) != 0) return;  // of another byte order
  refuseCutOffVersion5(stream, path, size);
}

template <class Number>
void appendAs(const void* data, std::size_t count, std::vector<double>& values) {
  const auto* numbers = static_cast<const Number*>(data);
  values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<double>(numbers[i]));
}

bool isNumeric(matio_classes type) { return type >= MAT_C_DOUBLE && type <= MAT_C_UINT64; }

/// False for a type that is not a number.
bool appendNumbers(const matvar_t& variable, std::size_t count, std::vector<double>& values) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      appendAs<double>(variable.data, count, values);
      return true;
    case MAT_C_SINGLE:
      appendAs<float>(variable.data, count, values);
      return true;
    case MAT_C_INT8:
      appendAs<std::int8_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT8:
      appendAs<std::uint8_t>(variable.data, count, values);
      return true;
    case MAT_C_INT16:
      appendAs<std::int16_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT16:
      appendAs<std::uint16_t>(variable.data, count, values);
      return true;
    case MAT_C_INT32:
      appendAs<std::int32_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT32:
      appendAs<std::uint32_t>(variable.data, count, values);
      return true;
    case MAT_C_INT64:
      appendAs<std::int64_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT64:
      appendAs<std::uint64_t>(variable.data, count, values);
      return true;
    default:
      return false;
  }
}

/// Whether a file of that size can hold the matrix that its header tells of. A number takes a byte
/// at least, and deflate makes at most 1032 bytes of one. Else a damaged header would make the
/// library take memory for whatever it says.
bool fitsFile(const matvar_t& told, std::uintmax_t file_bytes) {
  constexpr double kMostNumbersInByte = 1032.0;
  double numbers = 1.0;
  for (int i = 0; i < told.rank; ++i) numbers *= static_cast<double>(told.dims[i]);
  return numbers <= kMostNumbersInByte * static_cast<double>(file_bytes);
}

}  // namespace

struct MatFile::Handle {
  explicit Handle(mat_t* opened) : file(opened) {}
  ~Handle() { Mat_Close(file); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  mat_t* file;
};

MatFile::MatFile(const fs::path& path) : path_(path) {
  if (!fs::is_regular_file(path)) {
    throw InputError(path.string() + " does not exist or is not a file; check the path.");
  }
  refuseIfCutOff(path);
  mat_t* opened = Mat_Open(path.c_str(), MAT_ACC_RDONLY);
  if (opened == nullptr) {
    throw InputError(path.string() +
                     " is not a MATLAB file, or its beginning is damaged; give a"
                     " .mat file as MATLAB saves it.");
  }
  handle_ = std::make_unique<Handle>(opened);
  while (const Variable variable{Mat_VarReadNextInfo(opened)}) {
    if (variable->name != nullptr) variables_.insert(variable->name);
  }
}

MatFile::~MatFile() = default;
MatFile::MatFile(MatFile&&) noexcept = default;
MatFile& MatFile::operator=(MatFile&&) noexcept = default;

std::string MatFile::origin(const std::string& variable) const {
  return path_.string() + ": variable " + variable;
}

MatMatrix MatFile::read(const std::string& variable) const {
  if (!contains(variable)) {
    throw InputError(path_.string() + " holds no variable " + variable +
                     " (found: " + listOf(variables_) +
                     "); give the file as it was published, or rename the variable.");
  }
  const Variable told{Mat_VarReadInfo(handle_->file, variable.c_str())};
  if (!told || told->rank != 2 || told->isComplex != 0 || !isNumeric(told->class_type)) {
    throw InputError(origin(variable) + " is not a plain matrix of real numbers" + kDamaged);
  }
  if (!fitsFile(*told, fs::file_size(path_))) {
    throw InputError(origin(variable) + " claims to be larger than the file can hold" + kDamaged);
  }
  const Variable read{Mat_VarRead(handle_->file, variable.c_str())};
  if (!read || (read->data == nullptr && read->nbytes > 0)) {
    throw InputError(origin(variable) + " cannot be read" + kDamaged);
  }
  MatMatrix matrix;
  matrix.rows = read->dims[0];
  matrix.columns = read->dims[1];
  const std::size_t count = matrix.rows * matrix.columns;
  if (count > 0 &&
      (read->data == nullptr || count * Mat_SizeOfClass(read->class_type) != read->nbytes ||
       !appendNumbers(*read, count, matrix.values))) {
    throw InputError(origin(variable) + " does not hold the numbers it should" + kDamaged);
  }
  return matrix;
}

std::vector<double> MatFile::readVector(const std::string& variable) const {
  MatMatrix matrix = read(variable);
  if (matrix.rows > 1 && matrix.columns > 1) {
    throw InputError(origin(variable) + " is a matrix of " + std::to_string(matrix.rows) + " x " +
                     std::to_string(matrix.columns) +
                     ", but should be a single row or column of numbers; correct it.");
  }
  return std::move(matrix.values);
}

}  // namespace hymm::core
