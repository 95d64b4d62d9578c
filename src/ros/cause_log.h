#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>

namespace hymm {

/// Counts what went wrong by cause, and tells each cause once in the log. Thread-safe.
class CauseLog {
 public:
  /// Causes hold names that come in messages. However many names come, this many causes are kept;
  /// what comes after them is counted as `kOthers`.
  static constexpr std::size_t kMostCauses = 64;
  static constexpr std::size_t kLongestCause = 200;  ///< in bytes; the rest is cut off
  static constexpr const char* kOthers = "other causes";

  /// Counts `cause` (a few words, the same each time). The first time, the log gets `sentence`.
  void count(const std::string& cause, const std::string& sentence);

  std::map<std::string, std::size_t> counts() const;
  std::size_t total() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::size_t> counts_;
};

}  // namespace hymm
