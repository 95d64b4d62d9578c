#include "door_planner/ltr_problem.h"

#include <cstdint>

#include "hybrid_map/input_check.h"

namespace hymm::core {
namespace {

/// Of one LTR. What has more cells, or is wider, comes of a message that makes no sense, and its
/// portals would fill the memory.
constexpr std::int64_t kMostCells = 1 << 22;
constexpr double kWidest_m = 1e4;
/// Ratio of the longest to the shortest direction in a cell, about: so many steps, and as long
/// ones, the search in it needs. New LTRs have angles of 0.01 at least, which make 200 of it.
constexpr double kMostSheared = 256.0;
/// The index keeps LTRs in a row by their numbers.
constexpr int kMostLtrs = 1 << 22;

}  // namespace

std::optional<LtrProblem> problemOf(const LtrView& view) {
  if (view.id < 0 || view.id >= kMostLtrs) return LtrProblem::kId;
  for (const Eigen::Vector2d& corner : view.corners) {
    if (!isPlace(corner)) return LtrProblem::kPlace;
    if (!((corner - view.corners[0]).norm() <= 0.5 * kWidest_m)) return LtrProblem::kTooWide;
  }
  if (!(turn(view.corners[0], view.corners[1], view.corners[2]) > 1e-9)) return LtrProblem::kFlat;
  if (view.alpha_cells <= 0 || view.beta_cells <= 0) return LtrProblem::kNoCells;
  const std::int64_t cells = std::int64_t{view.alpha_cells} * view.beta_cells;
  if (cells > kMostCells) return LtrProblem::kTooManyCells;
  const Eigen::Matrix2d cell =
      Triangle(view.corners).edges() *
      Eigen::Vector2d(1.0 / view.alpha_cells, 1.0 / view.beta_cells).asDiagonal();
  if (!(cell.squaredNorm() <= kMostSheared * cell.determinant())) return LtrProblem::kNarrowCells;
  return std::nullopt;
}

std::string wordsFor(LtrProblem problem) {
  switch (problem) {
    case LtrProblem::kId:
      return "has a senseless number";
    case LtrProblem::kPlace:
      return "has a corner that is no place on earth";
    case LtrProblem::kTooWide:
      return "has sides of kilometres";
    case LtrProblem::kFlat:
      return "has corners in a line, or clockwise";
    case LtrProblem::kNoCells:
      return "has no cells";
    case LtrProblem::kTooManyCells:
      return "has more cells than plans have memory for (raise hymm_grid's resolution_m)";
    case LtrProblem::kNarrowCells:
      return "has cells too long and narrow to search in";
  }
  return "cannot be used";
}

std::map<std::string, std::size_t> countsOf(const UnusableLtrs& ltrs) {
  std::map<std::string, std::size_t> counts;
  for (const auto& [id, problem] : ltrs) ++counts[wordsFor(problem)];
  return counts;
}

}  // namespace hymm::core
