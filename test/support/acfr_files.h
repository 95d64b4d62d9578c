#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include <matio.h>

#include "support/temporary_folder.h"

namespace hymm::test {

inline constexpr std::size_t kAcfrBeams = 361;

/// A line of LASER.txt, without its end: `time_s`, then 361 times no return, but `range` on the
/// beam `beam` (0: right, 180: ahead, 360: left).
inline std::string acfrScanText(const std::string& time_s, std::size_t beam,
                                const std::string& range) {
  std::string text = time_s;
  for (std::size_t i = 0; i < kAcfrBeams; ++i) text += "\t" + (i == beam ? range : "81.91");
  return text + "\t";
}

/// A small recording in the form of Victoria Park's ASCII archive: two scans on one line, three
/// dead-reckoning rows, two fixes, and an order of events in which two rows are missing.
inline void writeAcfrAscii(const TemporaryFolder& folder) {
  folder.write("LASER.txt", acfrScanText("0.5", 0, "10") + acfrScanText("0.7", 180, "20.5"));
  folder.write("DRS.txt", "0.400\t 1.000\t 0.1000\r\n0.500\t 2.000\t-0.1\r\n0.600\t 2.0\t0\r\n");
  folder.write("GPS.txt", "0.000\t  3.00\t  4.00\r\n0.550\t 5.0\t 6.0\r\n");
  folder.write("Sensors_manager.txt",
               "0.000\t1\t1\r\n0.400\t2\t1\r\n0.500\t3\t1\r\n0.500\t2\t2\r\n0.550\t1\t2\r\n"
               "0.600\t2\t3\r\n0.650\t1\t3\r\n0.700\t3\t2\r\n0.900\t3\t3\r\n");
}

/// One numeric variable of a MATLAB file; `values` column after column.
struct MatVariable {
  std::string name;
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values;
  bool as_uint16 = false;
};

inline MatVariable matRow(const std::string& name, std::vector<double> values) {
  const std::size_t size = values.size();
  return {name, 1, size, std::move(values)};
}

/// Scans in which every beam of scan i has values[i].
inline MatVariable matScans(const std::string& name, const std::vector<double>& values,
                            bool as_uint16 = false) {
  MatVariable variable{name, values.size(), kAcfrBeams, {}, as_uint16};
  for (std::size_t k = 0; k < kAcfrBeams; ++k) {
    variable.values.insert(variable.values.end(), values.begin(), values.end());
  }
  return variable;
}

inline std::filesystem::path writeMatFile(const std::filesystem::path& path,
                                          const std::vector<MatVariable>& variables) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  if (file == nullptr) throw std::runtime_error("cannot make a MATLAB file");
  for (const MatVariable& variable : variables) {
    std::size_t dimensions[2] = {variable.rows, variable.columns};
    const std::vector<std::uint16_t> words(variable.values.begin(), variable.values.end());
    const void* data = variable.as_uint16 ? static_cast<const void*>(words.data())
                                          : static_cast<const void*>(variable.values.data());
    matvar_t* written =
        Mat_VarCreate(variable.name.c_str(), variable.as_uint16 ? MAT_C_UINT16 : MAT_C_DOUBLE,
                      variable.as_uint16 ? MAT_T_UINT16 : MAT_T_DOUBLE, 2, dimensions,
                      const_cast<void*>(data), 0);
    const int error = Mat_VarWrite(file, written, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(written);
    if (error != 0) throw std::runtime_error("cannot write " + variable.name);
  }
  Mat_Close(file);
  return path;
}

}  // namespace hymm::test
