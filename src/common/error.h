#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace hymm::core {

/// A configuration that cannot be used. what() lists every problem found, one a line.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(const std::vector<std::string>& problems);
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// A file or stream that cannot be read: what() names it, what is wrong, and what to do.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file or folder that cannot be written: what() names it and says why.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace hymm::core
