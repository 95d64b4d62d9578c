#include "ros/traffic_meter.h"

namespace hymm {
namespace {

constexpr double kOldInput_s = 2.0;

}  // namespace

void TrafficMeter::watch(const std::string& topic) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto [entry, is_new] = topics_.try_emplace(topic);
  if (is_new) entry->second.last_s = entry->second.told_s = clock_();
}

void TrafficMeter::expect(const std::string& topic) {
  watch(topic);
  const std::lock_guard<std::mutex> lock(mutex_);
  topics_[topic].is_expected = true;
}

void TrafficMeter::note(const std::string& topic) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++topics_[topic].messages;
  topics_[topic].last_s = clock_();
}

void TrafficMeter::addTo(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now_s = clock_();
  for (auto& [name, topic] : topics_) {
    const auto arrived = static_cast<double>(topic.messages - topic.messages_told);
    const double age_s = now_s - topic.last_s;
    status.add(name + " messages", topic.messages);
    status.add(name + " rate [Hz, wall]",
               now_s > topic.told_s ? arrived / (now_s - topic.told_s) : 0.0);
    status.add(name + " age [s, wall]", age_s);
    topic.messages_told = topic.messages;
    topic.told_s = now_s;
    if (!topic.is_expected) continue;
    if (topic.messages == 0) {
      status.mergeSummary(DiagnosticStatus::WARN, "Nothing has come on " + name);
    } else if (age_s > kOldInput_s) {
      status.mergeSummary(DiagnosticStatus::WARN, "Nothing comes on " + name + " any more");
    }
  }
}

void TrafficMeter::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "All inputs arrive");
  addTo(status);
}

}  // namespace hymm
