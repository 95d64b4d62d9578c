#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace hymm::core {

/// A numeric MATLAB variable of two dimensions, of any number type, as doubles.
struct MatMatrix {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values;  ///< column after column

  std::size_t size() const { return values.size(); }
  double at(std::size_t row, std::size_t column) const { return values[column * rows + row]; }
};

/// A MATLAB file. Throws InputError, which names the file and, where it is about one, the variable.
class MatFile {
 public:
  explicit MatFile(const std::filesystem::path& path);
  ~MatFile();
  MatFile(MatFile&&) noexcept;
  MatFile& operator=(MatFile&&) noexcept;

  bool contains(const std::string& variable) const { return variables_.count(variable) > 0; }
  const std::set<std::string>& variables() const { return variables_; }
  const std::filesystem::path& path() const { return path_; }

  /// How sentences name a variable of this file.
  std::string origin(const std::string& variable) const;

  MatMatrix read(const std::string& variable) const;

  /// A row or column of numbers.
  std::vector<double> readVector(const std::string& variable) const;

 private:
  struct Handle;

  std::filesystem::path path_;
  std::unique_ptr<Handle> handle_;
  std::set<std::string> variables_;
};

}  // namespace hymm::core
