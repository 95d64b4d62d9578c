#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <matio.h>

#include "common/error.h"
#include "datasets/mat_file.h"
#include "fuzz/harness.h"
#include "support/temporary_folder.h"

namespace hymm::test {
namespace {

struct Closed {
  void operator()(mat_t* file) const { Mat_Close(file); }
};

template <class Number>
void write(mat_t* file, const char* name, matio_classes kind, matio_types type,
           std::vector<Number> values, matio_compression compression) {
  std::size_t dimensions[2] = {values.size() / 3, 3};
  matvar_t* variable = Mat_VarCreate(name, kind, type, 2, dimensions, values.data(), 0);
  const int error = Mat_VarWrite(file, variable, compression);
  Mat_VarFree(variable);
  if (error != 0) throw std::runtime_error("cannot write a MATLAB file");
}

void writeMat(const std::string& path, mat_ft version, matio_compression compression) {
  const std::unique_ptr<mat_t, Closed> file(Mat_CreateVer(path.c_str(), nullptr, version));
  if (!file) throw std::runtime_error("cannot make a MATLAB file");
  std::vector<double> ranges(12);
  std::iota(ranges.begin(), ranges.end(), 0.0);
  write(file.get(), "LASER", MAT_C_DOUBLE, MAT_T_DOUBLE, ranges, compression);
  if (version == MAT_FT_MAT4) return;
  write<std::uint32_t>(file.get(), "TLsr", MAT_C_UINT32, MAT_T_UINT32, {1, 2, 3}, compression);
}

}  // namespace

/// All variables of a MATLAB file.
bool isRead(const std::uint8_t* data, std::size_t size) {
  try {
    const core::MatFile file(inputFile(data, size, ".mat"));
    for (const std::string& variable : file.variables()) file.read(variable);
    return true;
  } catch (const core::InputError&) {
    return false;
  }
}

std::map<std::string, std::string> seeds() {
  const TemporaryFolder folder;
  writeMat(folder / "plain.mat", MAT_FT_MAT5, MAT_COMPRESSION_NONE);
  writeMat(folder / "packed.mat", MAT_FT_MAT5, MAT_COMPRESSION_ZLIB);
  writeMat(folder / "old.mat", MAT_FT_MAT4, MAT_COMPRESSION_NONE);
  std::map<std::string, std::string> files;
  for (const char* name : {"plain.mat", "packed.mat", "old.mat"}) files[name] = folder.read(name);
  return files;
}

}  // namespace hymm::test
