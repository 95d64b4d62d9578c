#include "door_planner/cell_costs.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hymm::core {
namespace {

constexpr double kCornerShare = 1e-5;
constexpr float kOccupied = -std::numeric_limits<float>::infinity();

constexpr auto kDearest = static_cast<float>(PathCostConfig::kDearest);
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// Share from which a cell counts as one of a category.
constexpr float kMostly = 0.5F;

/// What a metre costs by the occupancy alone.
float costOf(const PathCostConfig& config, float probability) {
  if (std::isnan(probability)) {
    return config.unknown_is_occupied ? kOccupied
                                      : static_cast<float>(config.distance + config.unknown);
  }
  if (probability >= static_cast<float>(config.occupied_probability)) return kOccupied;
  double rounded = std::max(0.0, static_cast<double>(probability));
  if (config.probability_step > 0.0) {
    rounded = config.probability_step * std::round(rounded / config.probability_step);
  }
  return static_cast<float>(config.distance + config.occupancy * rounded);
}

}  // namespace

TriangularGrid gridOf(int alpha_cells, int beta_cells) {
  return {Triangle({Eigen::Vector2d::Zero(), Eigen::Vector2d(alpha_cells, 0.0),
                    Eigen::Vector2d(0.0, beta_cells)}),
          1.0};
}

CellCosts::CellCosts(const PathCostConfig& config, const TriangularGrid& grid)
    : CellCosts(config, {}, grid, {}) {}

CellCosts::CellCosts(const PathCostConfig& config, const std::vector<PropertyWeight>& weights,
                     const TriangularGrid& grid, const LtrContent& content)
    : grid_(grid) {
  const std::size_t count = std::size_t(grid.cellCount());
  values_.assign(count, costOf(config, std::numeric_limits<float>::quiet_NaN()));
  if (!content.occupancy.empty()) {
    if (content.occupancy.size() != count) {
      throw std::invalid_argument("an LTR's occupancy must have one value a cell");
    }
    std::transform(content.occupancy.begin(), content.occupancy.end(), values_.begin(),
                   [&](float probability) { return costOf(config, probability); });
  }
  for (const PropertyWeight& weight : weights) {
    if (weight.isDirected()) {
      addDirected(weight, content);
      continue;
    }
    const auto property = content.properties.find(weight.property);
    if (property != content.properties.end()) addProperty(weight, property->second);
  }
  finish();
  findObstacles();
}

void CellCosts::addProperty(const PropertyWeight& weight, const std::vector<float>& values) {
  if (values.size() != values_.size()) {
    throw std::invalid_argument("property " + weight.property +
                                " of an LTR must have one value a cell");
  }
  const float factor = static_cast<float>(weight.weight);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]) || values_[i] == kOccupied) continue;
    if (weight.kind == PropertyWeight::Kind::kForbidden) {
      if (values[i] >= factor) values_[i] = kOccupied;
    } else {
      // A map may hold any number, infinite ones too.
      values_[i] = std::min(kDearest, values_[i] + factor * std::max(0.0F, values[i]));
    }
  }
}

void CellCosts::addDirected(const PropertyWeight& weight, const LtrContent& content) {
  DirectedLayer layer;
  const auto factor = static_cast<float>(weight.weight);
  (weight.kind == PropertyWeight::Kind::kClimb ? layer.rise : layer.fall) = factor;
  const auto find = [&](const std::string& name) {
    const auto found = content.properties.find(name);
    if (found == content.properties.end()) return std::vector<float>();
    if (found->second.size() != values_.size()) {
      throw std::invalid_argument("property " + name + " of an LTR must have one value a cell");
    }
    return found->second;
  };
  if (const auto categories = weight.categories()) {
    const std::vector<float> first = find(categories->first), second = find(categories->second);
    if (!first.empty() || !second.empty()) layer.values.assign(values_.size(), kUnknown);
    for (std::size_t i = 0; i < layer.values.size(); ++i) {
      if (!first.empty() && first[i] >= kMostly) layer.values[i] = 0.0F;
      if (!second.empty() && second[i] >= kMostly) layer.values[i] = 1.0F;
    }
  } else {
    layer.values = find(weight.property);
  }
  is_directed_ = is_directed_ || !layer.values.empty();
  directed_.push_back(std::move(layer));
}

bool CellCosts::DirectedLayer::operator==(const DirectedLayer& other) const {
  return rise == other.rise && fall == other.fall &&
         std::equal(values.begin(), values.end(), other.values.begin(), other.values.end(),
                    [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); });
}

float CellCosts::passing(const CellCosts& one, int from, const CellCosts& other, int to) {
  float sum = 0.0F;
  for (std::size_t k = 0; k < std::min(one.directed_.size(), other.directed_.size()); ++k) {
    const DirectedLayer& here = one.directed_[k];
    const DirectedLayer& there = other.directed_[k];
    if (here.values.empty() || there.values.empty()) continue;
    const float rise = there.values[std::size_t(to)] - here.values[std::size_t(from)];
    if (rise > 0.0F) sum += here.rise * rise;
    if (rise < 0.0F) sum -= here.fall * rise;
  }
  return std::min(kDearest, sum);
}

void CellCosts::finish() {
  least_ = kNoPassing;
  for (const float value : values_) {
    if (value > 0.0F) least_ = std::min(least_, static_cast<double>(value));
  }
  const bool same = std::all_of(values_.begin(), values_.end(),
                                [this](float value) { return value == values_.front(); });
  if (!same) return;
  uniform_ = values_.front();
  values_.clear();
  values_.shrink_to_fit();
}

void CellCosts::findObstacles() {
  const int rows = grid_.betaCells();
  const auto isOpen = [&](int i, int j) {
    return j < 0 || j >= rows || i < 0 || i >= grid_.rowLength(j) || !isOccupied(grid_.index(i, j));
  };
  int cell = 0;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < grid_.rowLength(j); ++i, ++cell) {
      if (!isOccupied(cell)) continue;
      if (!isOpen(i - 1, j) && !isOpen(i + 1, j) && !isOpen(i, j - 1) && !isOpen(i, j + 1)) {
        continue;
      }
      obstacles_.emplace_back(
          (static_cast<float>(i) + 0.5F) / static_cast<float>(grid_.alphaCells()),
          (static_cast<float>(j) + 0.5F) / static_cast<float>(rows));
    }
  }
}

void CellCosts::setBlocked(const std::vector<bool>& blocked) {
  if (values_.empty()) values_.assign(std::size_t(grid_.cellCount()), uniform_);
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (values_[i] == kOccupied) continue;
    values_[i] = blocked[i] ? -std::abs(values_[i]) : std::abs(values_[i]);
  }
  finish();
}

std::vector<bool> CellCosts::blocked() const {
  std::vector<bool> blocked(std::size_t(grid_.cellCount()));
  for (int i = 0; i < grid_.cellCount(); ++i) {
    blocked[std::size_t(i)] = !isPassable(i) && !isOccupied(i);
  }
  return blocked;
}

double CellCosts::integrate(const Triangle::Local& from, const Triangle::Local& to,
                            double length_m) const {
  if (isUniform()) {
    return uniform_ > 0.0F ? length_m * static_cast<double>(uniform_) : kNoPassing;
  }
  const auto place = [this](const Triangle::Local& local) {
    return grid_.toCells(local.cwiseMax(0.0).cwiseMin(1.0 - 1e-12));
  };
  double sum = 0.0;
  int last = -1;
  const bool passes = traverseShares(place(from), place(to), [&](int i, int j, double share) {
    // A corner that the line only touches does not count.
    if (share < kCornerShare) return true;
    const int cell = grid_.index(i, j);
    const float cost = value(cell);
    if (!(cost > 0.0F)) return false;
    sum += share * length_m * static_cast<double>(cost);
    if (is_directed_ && last >= 0) sum += static_cast<double>(passing(last, cell));
    last = cell;
    return true;
  });
  return passes ? sum : kNoPassing;
}

std::size_t CellCosts::bytes() const {
  std::size_t directed = 0;
  for (const DirectedLayer& layer : directed_) directed += layer.values.capacity() * sizeof(float);
  return sizeof(*this) + values_.capacity() * sizeof(float) + directed +
         obstacles_.capacity() * sizeof(Eigen::Vector2f) +
         std::size_t(grid_.betaCells() + 1) * sizeof(int);
}

}  // namespace hymm::core
