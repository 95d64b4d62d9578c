#include "door_planner/districts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "door_planner/portal_search.h"

namespace hymm::core {
namespace {

std::uint64_t squareOf(const Eigen::Vector2d& place, double edge_m) {
  const auto column = static_cast<std::int32_t>(std::floor(place.x() / edge_m));
  const auto row = static_cast<std::int32_t>(std::floor(place.y() / edge_m));
  return std::uint64_t{static_cast<std::uint32_t>(column)} << 32U | static_cast<std::uint32_t>(row);
}

}  // namespace

DistrictLayout::DistrictLayout(std::shared_ptr<const DoorGraph> graph, double edge_m,
                               const DistrictLayout* before)
    : graph_(std::move(graph)) {
  const Triangle::Local middle(1.0 / 3.0, 1.0 / 3.0);
  district_of_ltr_.reserve(graph_->ltrs().size());
  for (const GraphLtr& ltr : graph_->ltrs()) {
    std::uint64_t key = squareOf(ltr.triangle.toGlobal(middle), edge_m);
    if (before != nullptr) {
      const auto known = before->key_of_id_.find(ltr.view.id);
      if (known != before->key_of_id_.end()) key = known->second;
    }
    key_of_id_.emplace(ltr.view.id, key);
    const auto [found, is_new] = by_key_.emplace(key, static_cast<int>(districts_.size()));
    if (is_new) {
      districts_.emplace_back();
      keys_.push_back(key);
    }
    districts_[std::size_t(found->second)].ltrs.push_back(
        static_cast<int>(district_of_ltr_.size()));
    district_of_ltr_.push_back(found->second);
  }
  findBorders();
}

// By LTR and side, which stays the same order as long as the district's LTRs do.
void DistrictLayout::findBorders() {
  rows_.assign(graph_->sides().size(), {kNone, kNone});
  for (std::size_t number = 0; number < districts_.size(); ++number) {
    District& district = districts_[number];
    district.first_portal = border_portals_;
    for (const int ltr : district.ltrs) {
      for (const int side_number : graph_->ltr(ltr).sides) {
        if (side_number == kNone) continue;
        const GraphSide& side = graph_->side(side_number);
        const std::size_t end = side.ltrs[0] == ltr ? 0 : 1;
        if (districtOf(side.ltrs[1 - end]) == static_cast<int>(number)) continue;
        rows_[std::size_t(side_number)][end] = district.portals;
        district.borders.push_back({side_number, end, district.portals, side.portals});
        district.portals += side.portals;
      }
    }
    border_portals_ += district.portals;
  }
}

int DistrictLayout::find(std::uint64_t key) const {
  const auto found = by_key_.find(key);
  return found == by_key_.end() ? kNone : found->second;
}

std::vector<DistrictMatrix::Source> DistrictLayout::sourcesOf(int district) const {
  std::vector<DistrictMatrix::Source> sources;
  for (const int number : districts_[std::size_t(district)].ltrs) {
    const GraphLtr& ltr = graph_->ltr(number);
    sources.push_back({ltr.view.id, ltr.factor, ltr.matrix});
  }
  return sources;
}

std::size_t DistrictLayout::bytes() const {
  std::size_t sum = sizeof(*this) + district_of_ltr_.capacity() * sizeof(int) +
                    rows_.capacity() * sizeof(rows_[0]) +
                    key_of_id_.size() * (sizeof(std::pair<int, std::uint64_t>) + sizeof(void*));
  for (const District& district : districts_) {
    sum += sizeof(District) + district.ltrs.capacity() * sizeof(int) +
           district.borders.capacity() * sizeof(Border);
  }
  return sum;
}

Districts::Districts(std::shared_ptr<const DoorGraph> graph, double edge_m, const Districts* before)
    : layout_(std::make_shared<const DistrictLayout>(
          std::move(graph), edge_m, before == nullptr ? nullptr : before->layout_.get())),
      matrices_(layout_->districts().size()) {
  if (before == nullptr) return;
  for (std::size_t number = 0; number < matrices_.size(); ++number) {
    const int old = before->layout_->find(layout_->keyOf(static_cast<int>(number)));
    if (old == kNone) continue;
    const std::shared_ptr<const DistrictMatrix>& kept = before->matrices_[std::size_t(old)];
    if (kept && kept->sources() == layout_->sourcesOf(static_cast<int>(number))) {
      matrices_[number] = kept;
    }
  }
}

std::size_t Districts::missing() const {
  return static_cast<std::size_t>(std::count(matrices_.begin(), matrices_.end(), nullptr));
}

Districts Districts::withMatrices(std::size_t max, PortalSearch& search) const {
  Districts more = *this;
  for (std::size_t number = 0; number < matrices_.size() && max > 0; ++number) {
    if (matrices_[number]) continue;
    more.matrices_[number] = compute(static_cast<int>(number), search);
    --max;
  }
  return more;
}

std::shared_ptr<const DistrictMatrix> Districts::compute(int number, PortalSearch& search) const {
  const DistrictLayout::District& district = layout_->districts()[std::size_t(number)];
  auto matrix = std::make_shared<DistrictMatrix>(layout_->sourcesOf(number), district.portals);
  PortalSearch::Scope scope;
  scope.graph = graph().get();
  scope.districts = this;
  scope.only = number;
  for (const DistrictLayout::Border& from : district.borders) {
    const GraphSide& side = graph()->side(from.side);
    for (int i = 0; i < side.portals; ++i) {
      search.begin(scope, nullptr, nullptr);
      search.offerFrom(side.first_portal + i, side.ltrs[from.end]);
      search.run();
      float* row = matrix->row(from.first_portal + i);
      for (const DistrictLayout::Border& to : district.borders) {
        const GraphSide& reached = graph()->side(to.side);
        for (int j = 0; j < reached.portals; ++j) {
          row[to.first_portal + j] = search.costTo(reached.first_portal + j);
        }
      }
    }
  }
  return matrix;
}

std::size_t Districts::bytes() const {
  std::size_t sum = sizeof(*this) + layout_->bytes() + matrices_.capacity() * sizeof(matrices_[0]);
  for (const auto& matrix : matrices_) sum += matrix ? matrix->bytes() : 0;
  return sum;
}

}  // namespace hymm::core
