#include "supervisor/suspicion.h"

#include "common/chi_square.h"

namespace hymm::core {

void SuspicionConfig::describe(ConfigSchema& schema) {
  schema.number("ambiguity", ambiguity, Range::between(0.0, 1.0),
                "share of ambiguous observations that is suspicious");
  schema.number("nis_probability", nis_probability, Range::between(0.5, 0.9999999),
                "quantile of chi-square beyond which a scan's NIS is suspicious");
  schema.number("disagreement", disagreement, Range::between(0.0, 1.0),
                "lack of correlation of scan and stored grid that is suspicious");
  schema.number("unexplained", unexplained, Range::between(0.0, 1.0),
                "share of unexplained observations that is suspicious");
  schema.number(
      "unseen", unseen, Range::between(0.0, 1.0),
      "share of the old landmarks that should be in view, but have not been seen lately, that "
      "is suspicious");
  schema.integer("old_landmarks", old_landmarks, Range::between(1, 1000),
                 "old landmarks that should be in view for any of these shares to count");
  schema.number("armed_deviation_m", armed_deviation_m, Range::positive(),
                "deviation of the position from which on fewer suspicious scans switch");
  schema.number("armed_deviation_rad", armed_deviation_rad, Range::positive(),
                "the same of the heading");
}

bool isArmed(const ScanEvidence& scan, const SuspicionConfig& config) {
  return scan.position_deviation_m > config.armed_deviation_m ||
         scan.heading_deviation_rad > config.armed_deviation_rad;
}

double nisLimit(int dof, const SuspicionConfig& config) {
  return dof > 0 ? chiSquareQuantile(config.nis_probability, dof) / dof : 0.0;
}

std::string findSuspicion(const ScanEvidence& scan, const SuspicionConfig& config) {
  if (scan.dof > 0 && scan.nis > nisLimit(scan.dof, config) * scan.dof) {
    return "observations do not fit the landmarks that they are taken for";
  }
  // A share of one or two landmarks says nothing, and where there are no more the relocaliser could
  // not help.
  if (scan.old_landmarks_expected < config.old_landmarks) return {};
  if (scan.ambiguity > config.ambiguity) return "observations are ambiguous";
  if (scan.disagreement > config.disagreement) return "the scan contradicts the stored grid";
  if (scan.unseen > config.unseen) return "old landmarks that should be in view are not seen";
  if (scan.unexplained > config.unexplained) {
    return "old landmarks should be in view, but what is seen is none of them";
  }
  return {};
}

}  // namespace hymm::core
