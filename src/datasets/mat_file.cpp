#include "datasets/mat_file.h"

#include <cstdint>

#include <matio.h>

#include "common/error.h"
#include "datasets/mat_structure.h"

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
  checkMatStructure(path);
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
