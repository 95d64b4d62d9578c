#include "pipeline/sight_report.h"

#include <algorithm>
#include <sstream>

namespace hymm::core {

void SightReport::take(const LaserScan& scan) {
  ++scans_;
  if (scan.intensities.empty() || scan.intensities.size() != scan.ranges_m.size()) return;
  ++scans_with_intensities_;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!scan.isHit(static_cast<double>(scan.ranges_m[i]))) continue;
    // A NaN is not larger than anything.
    if (scan.intensities[i] > largest_intensity_) largest_intensity_ = scan.intensities[i];
  }
}

std::vector<std::string> SightReport::sentences(const CekfSlam::Counts& counts,
                                                std::size_t landmarks) const {
  std::vector<std::string> sentences;
  if (counts.scans > 0 && landmarks == 0 && counts.landmarks_created == 0) {
    std::ostringstream sentence;
    sentence << "no landmark was found in " << counts.scans << " scans ("
             << (counts.observations == 0 ? "nothing in them looked like one"
                                          : "what looked like one was not seen often enough")
             << "): the trajectory is dead reckoning, and there is no NIS";
    sentences.push_back(sentence.str());
  }
  if (config_.reflectors.enabled && scans_ > 0) {
    std::string sentence = reflectorSentence();
    if (!sentence.empty()) sentences.push_back(std::move(sentence));
  }
  return sentences;
}

std::string SightReport::reflectorSentence() const {
  std::ostringstream sentence;
  if (scans_with_intensities_ == 0) {
    sentence << "reflectors cannot be seen: none of " << scans_
             << " scans has intensities that can be used";
  } else if (static_cast<double>(largest_intensity_) < config_.reflectors.min_intensity) {
    sentence << "no beam was bright enough for a reflector: the largest intensity of "
             << scans_with_intensities_ << " scans is " << largest_intensity_
             << ", perception/reflectors/min_intensity " << config_.reflectors.min_intensity;
  }
  return sentence.str();
}

}  // namespace hymm::core
