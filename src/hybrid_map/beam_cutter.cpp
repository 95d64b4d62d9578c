#include "hybrid_map/beam_cutter.h"

#include <algorithm>
#include <limits>

namespace hymm::core {
namespace {

// Shares of a beam. Pieces that are shorter are left out, their neighbours take their place.
constexpr double kNegligible = 1e-9;

// Around a vertex a beam may pass through as many LTRs as meet there without getting on. More steps
// than this without progress are rounding going in circles; then it jumps.
constexpr int kMaxIdleSteps = 16;
constexpr double kJump = 1e-7;

}  // namespace

/// The whole beam in the coordinates of an LTR, or of map.
BeamPiece BeamCutter::wholeBeamIn(int ltr) const {
  if (ltr == kNone) return {kNone, 0.0, 1.0, start_, end_ - start_};
  const Triangle& triangle = mesh_.ltr(ltr).triangle;
  return {ltr, 0.0, 1.0, triangle.toLocal(start_), triangle.edgesInverse() * (end_ - start_)};
}

void BeamCutter::cut(const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                     std::vector<BeamPiece>& pieces) {
  start_ = start;
  end_ = end;
  const std::size_t begin = pieces.size();
  hint_ = mesh_.locate(start, hint_);
  int ltr = hint_, entered_side = kNone, left_ltr = kNone, idle_steps = 0;
  double at = 0.0;
  while (at < 1.0) {
    BeamPiece beam = wholeBeamIn(ltr);
    Crossing next;
    if (ltr != kNone) {
      next = leaveOf(beam, entered_side);
    } else {
      next = nextEntry(at, left_ltr);
      for (Crossing missed = missedEntry(at, next.at); missed.ltr != kNone;) {
        next = missed;
        missed = next.at - at > kNegligible ? missedEntry(at, next.at) : Crossing{};
      }
    }
    next.at = std::max(next.at, at);
    if (next.at - at > kNegligible) {
      idle_steps = 0;
      beam.from = pieces.size() > begin ? pieces.back().to : 0.0;
      beam.to = next.at;
      pieces.push_back(beam);
    } else {
      ++idle_steps;
    }
    left_ltr = ltr;
    ltr = next.ltr;
    entered_side = next.side;
    at = next.at;
    if (idle_steps > kMaxIdleSteps) {
      at = std::min(1.0, at + kJump);
      ltr = mesh_.locate(start_ + at * (end_ - start_));
      entered_side = left_ltr = kNone;
      idle_steps = 0;
    }
  }
  if (pieces.size() == begin) pieces.push_back(wholeBeamIn(hint_));
  pieces.back().to = 1.0;
}

/// Where the beam leaves an LTR that it entered through a side, and into which one.
BeamCutter::Crossing BeamCutter::leaveOf(const BeamPiece& beam, int entered_side) const {
  const Triangle::Weights first = Triangle::weights(beam.start);
  const double falls[] = {beam.along.sum(), -beam.along.x(), -beam.along.y()};  // of the weights
  Crossing leave;
  int leave_side = kNone;
  for (int vertex = 0; vertex < 3; ++vertex) {
    const int side = (vertex + 1) % 3;  // opposite to the vertex, whose weight is 0 on it
    // Most sides are seen not to come first without a division.
    if (side == entered_side || falls[vertex] <= 0.0) continue;
    if (first[vertex] >= leave.at * falls[vertex]) continue;
    leave.at = first[vertex] / falls[vertex];
    leave_side = side;
  }
  if (leave_side == kNone) return leave;
  const Ltr& ltr = mesh_.ltr(beam.ltr);
  leave.ltr = ltr.neighbours[std::size_t(leave_side)];
  if (leave.ltr == kNone) return leave;
  const std::array<int, 3>& back = mesh_.ltr(leave.ltr).neighbours;
  leave.side = static_cast<int>(std::find(back.begin(), back.end(), beam.ltr) - back.begin());
  return leave;
}

/// Where the beam, outside of all LTRs, enters one through a side that no other shares. It cannot
/// be the convex LTR that it has just left.
BeamCutter::Crossing BeamCutter::nextEntry(double from, int left_ltr) const {
  const Eigen::Vector2d along = end_ - start_;
  Crossing entry;
  const auto look = [&](int index) {
    const Ltr& ltr = mesh_.ltr(index);
    if (!ltr.is_on_rim || index == left_ltr) return;
    const Corners corners = mesh_.corners(index);
    for (std::size_t k = 0; k < 3; ++k) {
      if (ltr.neighbours[k] != kNone) continue;
      const Eigen::Vector2d& corner = corners[k];
      const Eigen::Vector2d side = corners[(k + 1) % 3] - corner;
      const Eigen::Vector2d inward(-side.y(), side.x());
      const double speed = along.dot(inward);
      if (speed <= 0.0) continue;
      const double at = (corner - start_).dot(inward) / speed;
      if (at < from - kNegligible || at >= entry.at) continue;
      const double along_side = (start_ + at * along - corner).dot(side) / side.squaredNorm();
      if (along_side < -kNegligible || along_side > 1.0 + kNegligible) continue;
      entry = {index, static_cast<int>(k), at};
    }
  };
  mesh_.index().visitAlong(start_ + from * along, end_, look);
  return entry;
}

/// A beam that meets the border in a vertex may slip past both sides by rounding, or seem to leave
/// an LTR where it begins: then the middle of what seems to be outside is not. The entry found lies
/// in the first half.
BeamCutter::Crossing BeamCutter::missedEntry(double from, double to) const {
  constexpr double kGrazing = 1e-6;  // distance from the border in local weights
  const double middle = 0.5 * (from + to);
  const Eigen::Vector2d place = start_ + middle * (end_ - start_);
  const int index = mesh_.locate(place);
  if (index == kNone) return {};
  const Triangle& triangle = mesh_.ltr(index).triangle;
  if (Triangle::weights(triangle.toLocal(place)).minCoeff() < kGrazing) return {};
  const Triangle::Weights first = Triangle::weights(triangle.toLocal(start_));
  const Triangle::Weights last = Triangle::weights(triangle.toLocal(end_));
  Crossing entry{index, kNone, from};
  for (int vertex = 0; vertex < 3; ++vertex) {
    if (last[vertex] <= first[vertex]) continue;
    entry.at = std::max(entry.at, first[vertex] / (first[vertex] - last[vertex]));
  }
  entry.at = std::min(entry.at, middle);
  return entry;
}

}  // namespace hymm::core
