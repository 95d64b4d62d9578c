#include "evaluation/evaluation_report.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "evaluation/constellation.h"

namespace hymm::core {
namespace {

JsonObject statisticsJson(const ErrorStatistics& statistics) {
  JsonObject json;
  json.add("rmse_m", statistics.rmse).add("median_m", statistics.median);
  json.add("max_m", statistics.max).add("count", statistics.count);
  return json;
}

JsonObject consistencyJson(const Consistency& consistency) {
  JsonObject json;
  json.add("mean", consistency.mean).add("mean_per_dof", consistency.mean_per_dof);
  json.add("share_in_95_percent_band", consistency.share_in_band);
  json.add("count", consistency.count);
  return json;
}

JsonObject transformJson(const Pose2& T) {
  JsonObject json;
  json.add("x_m", T.x_m).add("y_m", T.y_m).add("yaw_rad", T.yaw_rad);
  return json;
}

/// Compares a run with its reference, one kind of error after the other.
class Evaluation {
 public:
  Evaluation(const RunResults& results, const Reference& reference,
             const EvaluationOptions& options)
      : results_(results), reference_(reference), options_(options), estimate_(stampedPoses()) {}

  EvaluationReport report() {
    JsonObject window;
    window.add("from", options_.window.from_s).add("to", options_.window.to_s);
    report_.json.add("window_s", window).add("scans", results_.poses.size());
    report_.json.add("resets", results_.resets);
    if (results_.resets > 0) {
      remark("The map was begun anew " + std::to_string(results_.resets) +
             " times; only what follows the last time is evaluated.");
    }
    addTrajectory();
    addGps();
    addLandmarks();
    addNis();
    return std::move(report_);
  }

 private:
  Trajectory stampedPoses() const {
    std::vector<StampedPose> poses;
    poses.reserve(results_.poses.size());
    for (const UncertainPose& pose : results_.poses) poses.push_back(pose.pose);
    return Trajectory(std::move(poses));
  }

  void remark(const std::string& sentence) { report_.remarks.push_back(sentence); }

  void addTrajectory() {
    if (reference_.poses.empty()) {
      report_.json.addNull("trajectory");
      return;
    }
    Trajectory truth(reference_.poses);
    if (!reference_.in_map_frame) {
      if (!findMapOrigin(truth)) {
        remark("There is no true pose at the time of any estimated one.");
        report_.json.addNull("trajectory");
        return;
      }
      truth = inFrameOf(T_truth_map_, truth);
    }
    const auto errors = computePoseErrors(results_.poses, truth, options_.window);
    if (!errors) {
      remark("There is no true pose at the time of any estimated one in the window.");
      report_.json.addNull("trajectory");
      return;
    }
    T_truth_aligned_ = T_truth_map_ * errors->T_truth_map;
    JsonObject json = statisticsJson(errors->position_m);
    json.add("aligned", statisticsJson(errors->aligned_position_m));
    json.add("heading_rmse_rad", errors->heading_rmse_rad);
    json.add("nees", consistencyJson(errors->nees));
    json.add("poses_without_truth", errors->without_truth);
    report_.json.add("trajectory", json);
  }

  /// The map's place in the truth's frame: the true pose when the map began. Recordings whose truth
  /// begins later: as the first estimate with a true pose has it.
  bool findMapOrigin(const Trajectory& truth) {
    for (const StampedPose& pose : estimate_.poses()) {
      if (const auto true_pose = truth.at(pose.time_s)) {
        T_truth_map_ = *true_pose * inverse(pose.pose);
        return true;
      }
    }
    return false;
  }

  void addGps() {
    if (reference_.fixes.empty()) {
      report_.json.addNull("gps");
      remark("There are no GPS fixes to compare with.");
      return;
    }
    if (!reference_.gps_antenna) {
      report_.json.addNull("gps");
      remark("The results do not tell where the GPS antenna stands; give --antenna X Y.");
      return;
    }
    const auto errors =
        computeGpsErrors(estimate_, reference_.fixes, *reference_.gps_antenna, options_.window);
    if (!errors) {
      report_.json.addNull("gps");
      remark("Fewer than three GPS fixes of the window can be compared.");
      return;
    }
    T_gps_map_ = errors->T_gps_map;
    JsonObject json = statisticsJson(errors->distance_m);
    json.add("unreachable_fixes", errors->unreachable);
    json.add("fixes_without_pose", errors->without_pose);
    json.add("antenna_m", std::vector{reference_.gps_antenna->x(), reference_.gps_antenna->y()});
    json.add("alignment", transformJson(errors->T_gps_map));
    report_.json.add("gps", json);
  }

  void addLandmarks() {
    if (reference_.landmarks.empty()) {
      report_.json.addNull("landmarks");
      return;
    }
    LandmarkMatching matching;
    matching.gate_m = options_.landmark_gate_m;
    matching.missed_range_m = options_.missed_range_m;
    if (reference_.landmarks_in_gps_frame) {
      matching.T_truth_map = T_gps_map_;
      if (!fitsMost(matching)) addSurveyGuess(matching);
    } else {
      matching.T_truth_map = T_truth_map_;
      if (T_truth_aligned_) matching.other_guesses.push_back(*T_truth_aligned_);
    }
    const auto errors = computeLandmarkErrors(results_.landmarks, reference_.landmarks,
                                              estimate_.poses(), matching);
    if (!errors) {
      report_.json.addNull("landmarks");
      remark("No estimated landmark is within the gate of a true one.");
      return;
    }
    JsonObject json = statisticsJson(errors->distance_m);
    json.add("aligned", statisticsJson(errors->aligned_distance_m));
    json.add("matched", errors->distance_m.count).add("false", errors->false_landmarks);
    json.add("duplicates", errors->duplicates);
    json.add("missed", errors->missed).add("out_of_range", errors->out_of_range);
    json.add("nees", consistencyJson(errors->nees));
    json.add("alignment", transformJson(errors->T_truth_map));
    report_.json.add("landmarks", json);
  }

  bool fitsMost(const LandmarkMatching& matching) const {
    const auto errors =
        computeLandmarkErrors(results_.landmarks, reference_.landmarks, {}, matching);
    const std::size_t most = std::min(results_.landmarks.size(), reference_.landmarks.size());
    return errors && 2 * errors->distance_m.count >= most;
  }

  /// A survey may count from another place than the fixes, or come without any: then the pattern of
  /// the landmarks tells where it lies.
  void addSurveyGuess(LandmarkMatching& matching) {
    std::vector<Eigen::Vector2d> estimates;
    for (const LandmarkEstimate& estimate : results_.landmarks) {
      estimates.push_back(estimate.position);
    }
    const auto guess =
        findConstellation(estimates, reference_.landmarks, 0.5 * options_.landmark_gate_m);
    if (guess) matching.other_guesses.push_back(*guess);
  }

  void addNis() {
    ConsistencySum sum;
    for (const StampedNis& scan : results_.nis) {
      if (options_.window.contains(scan.time_s)) sum.add(scan.nis, scan.dof);
    }
    if (sum.result().count == 0) {
      report_.json.addNull("nis");
      remark("No scan of the window updated a landmark.");
      return;
    }
    report_.json.add("nis", consistencyJson(sum.result()));
  }

  const RunResults& results_;
  const Reference& reference_;
  const EvaluationOptions& options_;
  Trajectory estimate_;
  Pose2 T_truth_map_;
  Pose2 T_gps_map_;
  std::optional<Pose2> T_truth_aligned_;  ///< as the whole trajectory has it
  EvaluationReport report_;
};

}  // namespace

EvaluationReport evaluate(const RunResults& results, const Reference& reference,
                          const EvaluationOptions& options) {
  return Evaluation(results, reference, options).report();
}

}  // namespace hymm::core
