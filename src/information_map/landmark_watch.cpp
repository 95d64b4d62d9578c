#include "information_map/landmark_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

double smallestEigenvalue(const Matrix2d& P) {
  const double half_trace = 0.5 * P.trace();
  return std::max(0.0, half_trace - std::hypot(0.5 * (P(0, 0) - P(1, 1)), P(0, 1)));
}

/// By how much the border of a region may move when its covariance changes: of a direction the
/// deviation changes by dP / (s + s'), and never by more than the root of dP.
double regionChange(const Matrix2d& before, const Matrix2d& now) {
  const double difference = (now - before).norm();
  const double deviations =
      std::sqrt(smallestEigenvalue(before)) + std::sqrt(smallestEigenvalue(now));
  const double bound = std::sqrt(difference);
  return deviations > 0.0 ? std::min(bound, difference / deviations) : bound;
}

/// For each landmark the nearest of those whose covariance with it is told, or -1.
std::vector<int> nearestNeighbours(const LandmarkField& field) {
  std::vector<int> nearest(std::size_t(field.size()), -1);
  std::vector<double> distance(std::size_t(field.size()), std::numeric_limits<double>::infinity());
  const auto offer = [&](int of, int neighbour, double squared) {
    if (squared >= distance[std::size_t(of)]) return;
    distance[std::size_t(of)] = squared;
    nearest[std::size_t(of)] = neighbour;
  };
  for (int i = 0; i < field.size(); ++i) {
    for (const auto* pair = field.pairsBegin(i); pair != field.pairsEnd(i); ++pair) {
      const double squared = (field.position(i) - field.position(pair->second)).squaredNorm();
      offer(i, pair->second, squared);
      offer(pair->second, i, squared);
    }
  }
  return nearest;
}

Matrix2d relativeCovariance(const LandmarkField& field, int a, int b) {
  const int first = std::min(a, b), second = std::max(a, b);
  const auto* end = field.pairsEnd(first);
  const auto* pair = std::lower_bound(
      field.pairsBegin(first), end, second,
      [](const LandmarkField::Pair& entry, int index) { return entry.second < index; });
  Matrix2d relative = field.covariance(a) + field.covariance(b);
  if (pair != end && pair->second == second) relative -= pair->block + pair->block.transpose();
  return relative;
}

}  // namespace

LandmarkWatch::Told LandmarkWatch::describe(const LandmarkField& field, int index,
                                            int neighbour) const {
  Told told{field.position(index), field.covariance(index), Matrix2d::Zero(), -1, comparisons_};
  if (neighbour >= 0) {
    told.neighbour_id = field.id(neighbour);
    told.relative = relativeCovariance(field, index, neighbour);
  }
  return told;
}

double LandmarkWatch::relativeChange(const Matrix2d& before, const Matrix2d& now) const {
  const double noise = tolerance_.range_deviation_m * tolerance_.range_deviation_m;
  return (now - before).norm() /
         (noise + std::min(smallestEigenvalue(before), smallestEigenvalue(now)));
}

ChangedLandmark LandmarkWatch::changeOf(const Told& before, const Told& now) const {
  ChangedLandmark change;
  change.place = now.place;
  change.moved_m = (now.place - before.place).norm() +
                   tolerance_.region_sigmas * regionChange(before.covariance, now.covariance);
  change.changed = relativeChange(before.covariance, now.covariance);
  if (before.neighbour_id == now.neighbour_id) {  // else the neighbour is told as gone
    change.changed = std::max(change.changed, relativeChange(before.relative, now.relative));
  }
  return change;
}

std::vector<ChangedLandmark> LandmarkWatch::compare(const LandmarkField& field) {
  ++comparisons_;
  std::vector<ChangedLandmark> changes;
  const std::vector<int> nearest = nearestNeighbours(field);
  for (int i = 0; i < field.size(); ++i) {
    const auto [entry, is_new] = told_.try_emplace(field.id(i));
    Told& told = entry->second;
    if (is_new) {
      told = describe(field, i, nearest[std::size_t(i)]);
      ChangedLandmark change;
      change.place = told.place;
      change.is_new = true;
      changes.push_back(change);
      continue;
    }
    // Against the same neighbour as before, if it is still there.
    const int same = told.neighbour_id < 0 ? -1 : field.indexOf(told.neighbour_id);
    const ChangedLandmark change =
        changeOf(told, describe(field, i, same >= 0 ? same : nearest[std::size_t(i)]));
    told.version_seen = comparisons_;
    if (change.moved_m <= tolerance_.moved_m && change.changed <= tolerance_.changed) continue;
    changes.push_back(change);
    told = describe(field, i, nearest[std::size_t(i)]);
  }
  // In the order of ids, so that the outcome does not depend on the hash.
  std::vector<int> gone;
  for (const auto& [id, told] : told_) {
    if (told.version_seen != comparisons_) gone.push_back(id);
  }
  std::sort(gone.begin(), gone.end());
  for (const int id : gone) {
    ChangedLandmark change;
    change.place = told_[id].place;
    change.is_gone = true;
    changes.push_back(change);
    told_.erase(id);
  }
  return changes;
}

LandmarkMotion::LandmarkMotion(const LandmarkField& from, const LandmarkField& to, double range_m)
    : from_(from), range_m_(range_m) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  displacement_.reserve(std::size_t(from.size()));
  for (int i = 0; i < from.size(); ++i) {
    const int now = to.indexOf(from.id(i));
    displacement_.emplace_back(now < 0 ? Vector2d(nan, nan)
                                       : Vector2d(to.position(now) - from.position(i)));
    if (now >= 0) largest_m_ = std::max(largest_m_, displacement_.back().norm());
  }
}

Vector2d LandmarkMotion::move(const Vector2d& place) const {
  constexpr double kNearest_m = 0.1;  // a place at a landmark goes with it
  Vector2d sum = Vector2d::Zero();
  double weights = 0.0;
  from_.visitNear(place, range_m_, [&](int index) {
    const Vector2d& displacement = displacement_[std::size_t(index)];
    if (std::isnan(displacement.x())) return;
    const double weight =
        1.0 / (kNearest_m * kNearest_m + (from_.position(index) - place).squaredNorm());
    sum += weight * displacement;
    weights += weight;
  });
  return weights > 0.0 ? Vector2d(place + sum / weights) : place;
}

}  // namespace hymm::core
