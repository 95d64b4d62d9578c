#include "ros/cause_log.h"

#include <ros/console.h>

namespace hymm {

void CauseLog::count(const std::string& cause, const std::string& sentence) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string name = cause.substr(0, kLongestCause);
  if (counts_.size() >= kMostCauses && counts_.count(name) == 0) name = kOthers;
  if (++counts_[name] == 1) {
    ROS_WARN_STREAM(sentence << " (Told once; counted in /diagnostics as '" << name << "'.)");
  }
}

std::map<std::string, std::size_t> CauseLog::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

std::size_t CauseLog::total() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::size_t total = 0;
  for (const auto& [cause, count] : counts_) total += count;
  return total;
}

}  // namespace hymm
