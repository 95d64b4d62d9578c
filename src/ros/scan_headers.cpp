#include "ros/scan_headers.h"

#include <algorithm>

#include "ros/time_conversions.h"

namespace hymm {
namespace {

constexpr std::size_t kMost = 1000;  // refused scans are never taken

}  // namespace

void ScanHeaders::remember(const std_msgs::Header& header) {
  headers_.push_back(header);
  if (headers_.size() > kMost) headers_.pop_front();
}

std_msgs::Header ScanHeaders::take(double time_s) {
  const auto found = std::find_if(headers_.begin(), headers_.end(), [&](const auto& header) {
    return header.stamp.toSec() == time_s;
  });
  std_msgs::Header header;
  if (found == headers_.end()) {
    header.stamp = toRosTime(time_s);
  } else {
    header = *found;
    headers_.erase(headers_.begin(), std::next(found));
  }
  return header;
}

}  // namespace hymm
