#include "cekf/constellation_place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "cekf/landmark_index.h"
#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Point = SeenConstellation::Point;

constexpr double kGate = 4.0;  // deviations
// Two poses nearer than this are the same place.
constexpr double kSamePlace_m = 1.0, kSameHeading_rad = 0.2;
constexpr int kFewestPairs = ConstellationPlace::kFewestPairs;
// These bound the work. Of what is seen, the nearest; of its pairs, the widest; each in so many.
constexpr std::size_t kMostSeen = 40, kMostBases = 24, kMostUses = 4;
constexpr std::size_t kMostLandmarks = 10000, kMostLandmarkPairs = 1000000;
constexpr double kShortestBase_m = 2.0;

/// Two landmarks, or two things seen, and how far they are apart.
struct Base {
  double length_m;
  int a, b;
};

class PlaceSearch {
 public:
  PlaceSearch(const SeenConstellation& question, double coincidence)
      : question_(question), least_log_odds_(-std::log(coincidence)) {
    const Matrix2d P = question.covariance.topLeftCorner<2, 2>();
    reach_m_ = kGate * std::sqrt(P.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
    turn_rad_ = kGate * std::sqrt(question.covariance(2, 2));
    chooseSeen();
    chooseLandmarks();
  }

  std::optional<ConstellationPlace> find() {
    if (seen_.size() < kFewestPairs || landmarks_.size() < kFewestPairs) return std::nullopt;
    if (landmarks_.size() > kMostLandmarks || !pairLandmarks()) return std::nullopt;
    for (const Base& base : basesSeen()) {
      const double gate_m = kGate * (deviation(seen(base.a)) + deviation(seen(base.b)));
      const auto first = std::lower_bound(
          pairs_.begin(), pairs_.end(), base.length_m - gate_m,
          [](const Base& pair, double length_m) { return pair.length_m < length_m; });
      for (auto pair = first; pair != pairs_.end() && pair->length_m <= base.length_m + gate_m;
           ++pair) {
        lookAt(base, pair->a, pair->b);
        lookAt(base, pair->b, pair->a);
      }
    }
    return decide();
  }

 private:
  struct Hypothesis {
    Pose2 pose;
    std::vector<int> landmarks;  ///< by seen_
    int pairs = 0;
    double log_odds = 0.0;
  };

  const Point& seen(int k) const { return question_.seen[std::size_t(seen_[std::size_t(k)])]; }
  const Point& landmark(int k) const {
    return question_.landmarks[std::size_t(landmarks_[std::size_t(k)])];
  }
  double deviation(const Point& seen) const { return std::sqrt(seen.variance_m2 + variance_m2_); }

  void chooseSeen() {
    for (std::size_t k = 0; k < question_.seen.size(); ++k) seen_.push_back(static_cast<int>(k));
    const auto is_nearer = [this](int a, int b) {
      return question_.seen[std::size_t(a)].position.norm() <
             question_.seen[std::size_t(b)].position.norm();
    };
    std::stable_sort(seen_.begin(), seen_.end(), is_nearer);
    if (seen_.size() > kMostSeen) seen_.resize(kMostSeen);
    for (const int k : seen_) {
      range_m_ = std::max(range_m_, question_.seen[std::size_t(k)].position.norm());
    }
  }

  void chooseLandmarks() {
    for (std::size_t k = 0; k < question_.landmarks.size(); ++k) {
      const Point& point = question_.landmarks[k];
      const double apart_m = (point.position - question_.expected.position()).norm();
      if (apart_m > reach_m_ + range_m_) continue;
      index_.place(static_cast<int>(landmarks_.size()), point.position);
      landmarks_.push_back(static_cast<int>(k));
      variance_m2_ = std::max(variance_m2_, point.variance_m2);
    }
  }

  /// All pairs that may be seen at once, by length. False if there are too many.
  bool pairLandmarks() {
    for (int a = 0; a < static_cast<int>(landmarks_.size()); ++a) {
      for (const int b : index_.near(landmark(a).position, 2.0 * range_m_)) {
        if (b <= a) continue;
        const double length_m = (landmark(a).position - landmark(b).position).norm();
        if (length_m >= 0.5 * kShortestBase_m) pairs_.push_back({length_m, a, b});
      }
      if (pairs_.size() > kMostLandmarkPairs) return false;
    }
    std::sort(pairs_.begin(), pairs_.end(), [](const Base& one, const Base& other) {
      return std::make_pair(one.length_m, std::make_pair(one.a, one.b)) <
             std::make_pair(other.length_m, std::make_pair(other.a, other.b));
    });
    return true;
  }

  /// Wide pairs fix the heading best; of several, one at least should be of two mapped things.
  std::vector<Base> basesSeen() const {
    std::vector<Base> all, chosen;
    for (int a = 0; a < static_cast<int>(seen_.size()); ++a) {
      for (int b = a + 1; b < static_cast<int>(seen_.size()); ++b) {
        const double length_m = (seen(a).position - seen(b).position).norm();
        if (length_m >= kShortestBase_m) all.push_back({length_m, a, b});
      }
    }
    std::stable_sort(all.begin(), all.end(), [](const Base& one, const Base& other) {
      return one.length_m > other.length_m;
    });
    std::vector<std::size_t> uses(seen_.size(), 0);
    for (const Base& base : all) {
      if (chosen.size() == kMostBases) break;
      std::size_t& of_a = uses[std::size_t(base.a)];
      std::size_t& of_b = uses[std::size_t(base.b)];
      if (of_a == kMostUses || of_b == kMostUses) continue;
      ++of_a;
      ++of_b;
      chosen.push_back(base);
    }
    return chosen;
  }

  /// The pose from which two things seen lie on the line through two landmarks, amid them.
  void lookAt(const Base& base, int landmark_a, int landmark_b) {
    const Point& a = seen(base.a);
    const Point& b = seen(base.b);
    const Point& at_a = landmark(landmark_a);
    const Point& at_b = landmark(landmark_b);
    if (!mayBeOneKind(a.type, at_a.type) || !mayBeOneKind(b.type, at_b.type)) return;
    const Vector2d along = b.position - a.position, along_map = at_b.position - at_a.position;
    const double yaw =
        wrapAngle(std::atan2(along_map.y(), along_map.x()) - std::atan2(along.y(), along.x()));
    const Vector2d middle = 0.5 * (a.position + b.position);
    const Vector2d position =
        0.5 * (at_a.position + at_b.position) - (Pose2{0.0, 0.0, yaw} * middle);
    Hypothesis found;
    found.pose = {position.x(), position.y(), yaw};
    if (!isExpected(found.pose)) return;
    pairUp(found);
    if (found.pairs < kFewestPairs) return;
    fit(found);
    pairUp(found);
    if (found.pairs < kFewestPairs || !isExpected(found.pose)) return;
    weigh(found);
    keep(std::move(found));
  }

  bool isExpected(const Pose2& pose) const {
    return (pose.position() - question_.expected.position()).norm() <= reach_m_ &&
           std::abs(wrapAngle(pose.yaw_rad - question_.expected.yaw_rad)) <= turn_rad_;
  }

  /// Each thing seen takes the nearest landmark that is free.
  void pairUp(Hypothesis& hypothesis) {
    hypothesis.landmarks.assign(seen_.size(), ConstellationPlace::kNone);
    hypothesis.pairs = 0;
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const Point& point = seen(static_cast<int>(k));
      const Vector2d place = hypothesis.pose * point.position;
      double nearest_m = kGate * deviation(point);
      for (const int other : index_.near(place, nearest_m)) {
        const double apart_m = (landmark(other).position - place).norm();
        if (apart_m > nearest_m || !mayBeOneKind(point.type, landmark(other).type)) continue;
        const auto& taken = hypothesis.landmarks;
        if (std::find(taken.begin(), taken.end(), other) != taken.end()) continue;
        nearest_m = apart_m;
        hypothesis.landmarks[k] = other;
      }
      if (hypothesis.landmarks[k] != ConstellationPlace::kNone) ++hypothesis.pairs;
    }
  }

  /// The pose that fits best to the pairs (least squares, weighted).
  void fit(Hypothesis& hypothesis) const {
    double all = 0.0;
    Vector2d centre = Vector2d::Zero(), centre_map = Vector2d::Zero();
    forPairs(hypothesis, [&](const Point& point, const Point& place, double weight) {
      all += weight;
      centre += weight * point.position;
      centre_map += weight * place.position;
    });
    centre /= all;
    centre_map /= all;
    double dot = 0.0, cross = 0.0;
    forPairs(hypothesis, [&](const Point& point, const Point& place, double weight) {
      const Vector2d d = point.position - centre, e = place.position - centre_map;
      dot += weight * d.dot(e);
      cross += weight * (d.x() * e.y() - d.y() * e.x());
    });
    const double yaw = std::atan2(cross, dot);
    const Vector2d position = centre_map - (Pose2{0.0, 0.0, yaw} * centre);
    hypothesis.pose = {position.x(), position.y(), yaw};
  }

  template <class Take>
  void forPairs(const Hypothesis& hypothesis, Take&& take) const {
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const int other = hypothesis.landmarks[k];
      if (other == ConstellationPlace::kNone) continue;
      const Point& point = seen(static_cast<int>(k));
      take(point, landmark(other), 1.0 / (point.variance_m2 + variance_m2_));
    }
  }

  /// A thing that is not in the map may be anywhere; one that is, at any landmark around.
  void weigh(Hypothesis& hypothesis) const {
    const Vector2d position = hypothesis.pose.position();
    const auto around =
        static_cast<double>(std::count_if(landmarks_.begin(), landmarks_.end(), [&](int k) {
          return (question_.landmarks[std::size_t(k)].position - position).norm() <= range_m_;
        }));
    const double density_per_m2 = std::max(around, 1.0) / (kPi * range_m_ * range_m_);
    double log_odds = 0.0, all = 0.0, moment = 0.0;
    Vector2d centre = Vector2d::Zero();
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const int other = hypothesis.landmarks[k];
      const Point& point = seen(static_cast<int>(k));
      const double variance = point.variance_m2 + variance_m2_;
      double fits = 0.0;
      if (other != ConstellationPlace::kNone) {
        const Vector2d place = hypothesis.pose * point.position;
        const double apart2 = (landmark(other).position - place).squaredNorm() / variance;
        fits = std::exp(-0.5 * apart2) / (2.0 * kPi * variance * density_per_m2);
        all += 1.0 / variance;
        centre += point.position / variance;
      }
      log_odds += std::log(0.5 + 0.5 * fits);
    }
    centre /= all;
    forPairs(hypothesis, [&](const Point& point, const Point&, double weight) {
      moment += weight * (point.position - centre).squaredNorm();
    });
    // How large a part of the poses expected this one is, by their deviations.
    const double area_m2 =
        std::sqrt(std::max(0.0, question_.covariance.topLeftCorner<2, 2>().determinant()));
    const double turn_rad = std::min(std::sqrt(question_.covariance(2, 2)), kPi / std::sqrt(3.0));
    const double poses = area_m2 * all * turn_rad * std::sqrt(moment);
    hypothesis.log_odds = log_odds - std::log(std::max(1.0, poses));
  }

  static bool isSame(const Pose2& a, const Pose2& b) {
    return (a.position() - b.position()).norm() <= kSamePlace_m &&
           std::abs(wrapAngle(a.yaw_rad - b.yaw_rad)) <= kSameHeading_rad;
  }

  /// The best pose, and the best one elsewhere.
  void keep(Hypothesis&& found) {
    if (!best_ || found.log_odds > best_->log_odds) {
      if (best_ && !isSame(found.pose, best_->pose)) rival_log_odds_ = best_->log_odds;
      best_ = std::move(found);
    } else if (!isSame(found.pose, best_->pose)) {
      rival_log_odds_ = std::max(rival_log_odds_, found.log_odds);
    }
  }

  std::optional<ConstellationPlace> decide() const {
    if (!best_ || best_->log_odds < least_log_odds_) return std::nullopt;
    if (best_->log_odds - rival_log_odds_ < least_log_odds_) return std::nullopt;
    ConstellationPlace place;
    place.T_map_base = best_->pose;
    place.pairs = best_->pairs;
    place.landmarks.assign(question_.seen.size(), ConstellationPlace::kNone);
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const int other = best_->landmarks[k];
      if (other == ConstellationPlace::kNone) continue;
      place.landmarks[std::size_t(seen_[k])] = landmarks_[std::size_t(other)];
    }
    return place;
  }

  const SeenConstellation& question_;
  double least_log_odds_;
  double reach_m_ = 0.0, turn_rad_ = 0.0;
  std::vector<int> seen_;       ///< of the question's, the nearest first
  std::vector<int> landmarks_;  ///< of the question's, those in reach
  double range_m_ = 0.0;        ///< of the farthest of seen_
  double variance_m2_ = 0.0;    ///< of landmarks
  LandmarkIndex index_;
  std::vector<Base> pairs_;  ///< of landmarks, by length
  std::optional<Hypothesis> best_;
  double rival_log_odds_ = -std::numeric_limits<double>::infinity();
};

}  // namespace

std::optional<ConstellationPlace> findConstellationPlace(const SeenConstellation& question,
                                                         double coincidence) {
  return PlaceSearch(question, coincidence).find();
}

}  // namespace hymm::core
