#include "perception/trunk_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/chi_square.h"

namespace hymm::core {
namespace {

/// The hits of a shape, thinned out evenly if there are more than the fit takes.
TrunkEvidence gatherEvidence(const BeamView& beams, int first, int last, int hits, double nearest_m,
                             int lower_gap, int upper_gap) {
  const double spacing = beams.spacing();
  const double middle = 0.5 * (first + last);
  const int stride = (hits + TrunkEvidence::kMaxHits - 1) / TrunkEvidence::kMaxHits;
  TrunkEvidence evidence;
  evidence.nearest_m = nearest_m;
  evidence.half_extent_rad = 0.5 * (last - first) * spacing;
  evidence.lower_gap_rad = lower_gap * spacing;
  evidence.upper_gap_rad = upper_gap * spacing;
  int seen = 0;
  for (int i = first; i <= last; ++i) {
    if (beams.kind(i) != BeamKind::kHit || seen++ % stride != 0) continue;
    const auto at = static_cast<std::size_t>(evidence.hits++);
    evidence.offsets_rad[at] = (i - middle) * spacing;
    evidence.ranges_m[at] = beams.range(i);
  }
  return evidence;
}

}  // namespace

TrunkDetector::TrunkDetector(const TrunkConfig& config, const LaserNoise& noise)
    : config_(config), noise_(noise), tan_max_incidence_(std::tan(config.max_incidence_rad)) {
  chi_square_limits_[0] = std::numeric_limits<double>::infinity();
  for (std::size_t dof = 1; dof < chi_square_limits_.size(); ++dof) {
    chi_square_limits_[dof] = chiSquareQuantile(config.shape_confidence, static_cast<int>(dof));
  }
}

void TrunkDetector::detect(const BeamView& beams, std::vector<Observation>& observations) const {
  int start = 0;
  if (beams.fullTurn()) {  // begin where no shape straddles the seam
    while (start < beams.size() &&
           (beams.kind(start) != BeamKind::kHit || nextOfShape(beams, start, -1) != start)) {
      ++start;
    }
    if (start == beams.size()) return;
  }
  const int end = start + beams.size();
  for (int index = start; index < end; ++index) {
    if (beams.kind(index) != BeamKind::kHit) continue;
    const Shape shape = shapeFrom(beams, index, end);
    index = shape.last;
    if (!mayBeTrunk(beams, shape)) continue;
    if (const auto observation = observe(beams, shape)) observations.push_back(*observation);
  }
}

// Over `steps` beams the range of the largest trunk grows by no more than sqrt(2 R s), s being the
// distance between the beams: the sagitta of a circle. The noise of two ranges comes on top.
double TrunkDetector::joinLimit(const BeamView& beams, double range_m, int steps) const {
  const double radius_m = 0.5 * config_.max_diameter_m;
  const double step_m = range_m * beams.spacing() * steps;
  return std::min(radius_m, std::sqrt(2.0 * radius_m * step_m)) +
         3.0 * std::sqrt(2.0) * noise_.range_noise_m;
}

/// The next hit of the same shape in a direction (+1, -1), or `hit` itself if the shape ends.
int TrunkDetector::nextOfShape(const BeamView& beams, int hit, int direction) const {
  const double range_m = beams.range(hit);
  for (int steps = 1; steps <= config_.max_missed_beams + 1; ++steps) {
    const int index = hit + direction * steps;
    if (!beams.contains(index)) return hit;
    const BeamKind kind = beams.kind(index);
    if (kind == BeamKind::kTooNear) return hit;
    if (kind != BeamKind::kHit) continue;
    const double other_m = beams.range(index);
    const bool same =
        std::abs(other_m - range_m) <= joinLimit(beams, std::min(range_m, other_m), steps);
    return same ? index : hit;
  }
  return hit;
}

TrunkDetector::Shape TrunkDetector::shapeFrom(const BeamView& beams, int first, int end) const {
  Shape shape{first, first, 1, beams.range(first)};
  for (int next = nextOfShape(beams, first, 1); next != shape.last && next < end;
       next = nextOfShape(beams, next, 1)) {
    shape.last = next;
    shape.nearest_m = std::min(shape.nearest_m, beams.range(next));
    ++shape.hits;
  }
  return shape;
}

/// Number of beams from the outermost hit of a shape to the next that is known to miss it, or
/// nothing if the scan does not show where the shape ends: at the border of the field of view,
/// beside something nearer, or beside a surface that may be its continuation.
std::optional<int> TrunkDetector::edgeGap(const BeamView& beams, int edge, int direction) const {
  const double range_m = beams.range(edge);
  for (int steps = 1;; ++steps) {
    const int index = edge + direction * steps;
    if (!beams.contains(index)) return std::nullopt;
    const BeamKind kind = beams.kind(index);
    if (kind == BeamKind::kTooNear) return std::nullopt;
    if (kind == BeamKind::kHit) {
      const double behind_m = beams.range(index) - range_m;
      const double surface_m = range_m * beams.spacing() * steps * tan_max_incidence_;
      const bool clear = behind_m > std::max(surface_m, joinLimit(beams, range_m, steps));
      return clear ? std::optional<int>(steps) : std::nullopt;
    }
    if (kind == BeamKind::kFree || steps > config_.max_missed_beams) return steps;
  }
}

bool TrunkDetector::mayBeTrunk(const BeamView& beams, const Shape& shape) const {
  if (shape.hits < config_.min_beams || shape.nearest_m > config_.max_range_m) return false;
  const int extent = shape.last - shape.first;
  // Two hits around a miss may as well be two thin things.
  if (shape.hits == 2 && extent > 1) return false;
  return shape.nearest_m * (extent * beams.spacing() - noise_.beam_width_rad) <=
         config_.max_diameter_m;
}

std::optional<Observation> TrunkDetector::observe(const BeamView& beams, const Shape& shape) const {
  const auto lower_gap = edgeGap(beams, shape.first, -1);
  if (!lower_gap) return std::nullopt;
  const auto upper_gap = edgeGap(beams, shape.last, 1);
  if (!upper_gap) return std::nullopt;
  const TrunkEvidence evidence = gatherEvidence(beams, shape.first, shape.last, shape.hits,
                                                shape.nearest_m, *lower_gap, *upper_gap);
  const TrunkEstimate estimate = fitTrunk(evidence, noise_, config_.surface_deviation);
  if (!isTrunk(estimate, evidence.hits)) return std::nullopt;
  return toObservation(beams, shape, estimate);
}

bool TrunkDetector::isTrunk(const TrunkEstimate& estimate, int hits) const {
  if (!std::isfinite(estimate.chi_square) ||
      estimate.chi_square > chi_square_limits_[static_cast<std::size_t>(hits - 1)]) {
    return false;
  }
  const double diameter_deviation_m = std::sqrt(estimate.covariance(2, 2));
  return estimate.mean[0] <= config_.max_range_m && estimate.mean[2] <= config_.max_diameter_m &&
         estimate.mean[2] + 2.0 * diameter_deviation_m >= config_.min_diameter_m;
}

Observation TrunkDetector::toObservation(const BeamView& beams, const Shape& shape,
                                         const TrunkEstimate& estimate) const {
  const double range_m = estimate.mean[0];
  const double direction = beams.increment() < 0.0 ? -1.0 : 1.0;
  const double middle = 0.5 * (shape.first + shape.last);
  Observation observation;
  observation.type = LandmarkType::kTrunk;
  observation.range_m = range_m;
  observation.bearing_rad = wrapAngle(beams.bearing(middle) + direction * estimate.mean[1]);
  observation.after_stamp_s = beams.afterStamp_s(middle);
  observation.covariance = estimate.covariance.topLeftCorner<2, 2>();
  observation.covariance(0, 1) *= direction;
  observation.covariance(1, 0) *= direction;
  // What no number of beams averages out: errors that an object's beams share, and a trunk that
  // is not round. An ellipse that is longer along the view by some radius is narrower across it by
  // as much: its front and its width put the centre off in the same direction. A trunk that is not
  // even symmetric has its edges off independently.
  const double outline_variance = std::pow(config_.outline_deviation * estimate.mean[2], 2);
  observation.covariance(0, 0) += std::pow(noise_.range_offset_deviation_m, 2) + outline_variance;
  observation.covariance(1, 1) += std::pow(noise_.bearing_offset_deviation_rad, 2) +
                                  0.125 * outline_variance / (range_m * range_m);
  observation.diameter_m = estimate.mean[2];
  observation.diameter_variance = estimate.covariance(2, 2) + outline_variance;
  observation.diameter_covariance << estimate.covariance(0, 2) + outline_variance,
      direction * estimate.covariance(1, 2);
  return observation;
}

}  // namespace hymm::core
