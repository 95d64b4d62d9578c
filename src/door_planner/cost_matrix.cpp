#include "door_planner/cost_matrix.h"

#include <algorithm>

namespace hymm::core {

CostMatrix::CostMatrix(LocalSearch& local, const std::vector<Triangle::Local>& portals,
                       bool is_directed)
    : size_(static_cast<int>(portals.size())) {
  Paths paths = search(local, portals, is_directed);
  close(paths);
  keep(paths);
}

CostMatrix::Paths CostMatrix::search(LocalSearch& search,
                                     const std::vector<Triangle::Local>& portals,
                                     bool is_directed) const {
  Paths paths(portals.size() * portals.size());
  for (int from = 0; from < size_; ++from) {
    const int first = is_directed ? 0 : from + 1;
    const std::vector<Triangle::Local> others(portals.begin() + first, portals.end());
    std::vector<LocalPath> found = search.find(portals[std::size_t(from)], others);
    for (int to = first; to < size_; ++to) {
      LocalPath& path = found[std::size_t(to - first)];
      if (!is_directed) {
        paths[at(to, from)] = path;
        std::reverse(paths[at(to, from)].points.begin(), paths[at(to, from)].points.end());
      }
      paths[at(from, to)] = std::move(path);
    }
    paths[at(from, from)] = {0.0, {portals[std::size_t(from)]}};
  }
  return paths;
}

// Paths that were pulled straight may be dearer than two others in a row; then these are taken, so
// that a search over portals need not enter an LTR that it has just left.
void CostMatrix::close(Paths& paths) const {
  for (int via = 0; via < size_; ++via) {
    for (int from = 0; from < size_; ++from) {
      if (from == via || !paths[at(from, via)].exists()) continue;
      for (int to = 0; to < size_; ++to) {
        const double around = paths[at(from, via)].cost + paths[at(via, to)].cost;
        LocalPath& path = paths[at(from, to)];
        if (to == via || to == from || !(around < path.cost * (1.0 - 1e-6))) continue;
        const std::vector<Triangle::Local>& rest = paths[at(via, to)].points;
        path = paths[at(from, via)];
        path.cost = around;
        path.points.insert(path.points.end(), rest.begin() + 1, rest.end());
      }
    }
  }
}

void CostMatrix::keep(const Paths& paths) {
  costs_.resize(paths.size());
  spans_.resize(paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    costs_[i] = static_cast<float>(paths[i].cost);
    if (paths[i].points.size() < 3) continue;
    const int from = static_cast<int>(i) / size_, to = static_cast<int>(i) % size_;
    const LocalPath& back = paths[at(to, from)];
    if (to < from && std::equal(paths[i].points.rbegin(), paths[i].points.rend(),
                                back.points.begin(), back.points.end())) {
      spans_[i] = spans_[at(to, from)];
      spans_[i].is_reversed = true;
      continue;
    }
    spans_[i].begin = static_cast<std::uint32_t>(turns_.size());
    spans_[i].count = static_cast<std::uint16_t>(paths[i].points.size() - 2);
    for (std::size_t k = 1; k + 1 < paths[i].points.size(); ++k) {
      turns_.push_back(paths[i].points[k].cast<float>());
    }
  }
  turns_.shrink_to_fit();
  if (turns_.empty()) spans_ = {};
}

std::vector<Triangle::Local> CostMatrix::turns(int from, int to) const {
  if (spans_.empty()) return {};
  const Span& span = spans_[at(from, to)];
  std::vector<Triangle::Local> turns;
  for (std::uint32_t i = 0; i < span.count; ++i) {
    turns.push_back(turns_[span.begin + i].cast<double>());
  }
  if (span.is_reversed) std::reverse(turns.begin(), turns.end());
  return turns;
}

std::size_t CostMatrix::bytes() const {
  return sizeof(*this) + costs_.capacity() * sizeof(float) + spans_.capacity() * sizeof(Span) +
         turns_.capacity() * sizeof(Eigen::Vector2f);
}

}  // namespace hymm::core
