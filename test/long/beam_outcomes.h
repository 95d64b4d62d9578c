#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include "hybrid_map/cell_traversal.h"
#include "hybrid_map/log_odds.h"
#include "perception/laser_scan.h"
#include "simulation/truth.h"

namespace hymm::core {

/// What became of the beams that reached each cell of the true world: how many ended in it, and how
/// many went on. Tells why a map misses a cell in which something stands.
class BeamOutcomes {
 public:
  explicit BeamOutcomes(const TrueOccupancy& truth)
      : truth_(truth), cells_(truth.occupied.size()) {}

  /// `T_map_laser` is true.
  void look(const LaserScan& scan, const Pose2& T_map_laser, double range_m, int lap) {
    const Eigen::Vector2d start = toCells(T_map_laser.position());
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const auto range = static_cast<double>(scan.ranges_m[i]);
      if (!scan.isHit(range) || range > range_m) continue;
      const double bearing = T_map_laser.yaw_rad + scan.bearing(i);
      const Eigen::Vector2d end = toCells(
          T_map_laser.position() + range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)));
      Cell* last = nullptr;
      traverseCells(start, end, [&](int x, int y) {
        if (last != nullptr) ++last->passed;
        last = find(x, y);
      });
      if (last == nullptr) continue;
      if (last->ended++ == 0) last->first_lap = lap;
    }
  }

  /// Shares of the beams that ended, of occupied cells that were met, by whether a map knows them.
  class Comparison {
   public:
    void add(bool is_found, double share, bool is_late) {
      (is_found ? found_ : missed_).push_back(share);
      if (is_late) ++(is_found ? late_found_ : late_missed_);
    }

    /// As JSON. `balance`: share of ending beams at which a cell neither gains nor loses.
    std::string text(const std::string& name, double balance) const {
      std::ostringstream text;
      const auto below = [balance](const std::vector<double>& shares) {
        const auto count = std::count_if(shares.begin(), shares.end(),
                                         [balance](double share) { return share < balance; });
        return static_cast<double>(count) / std::max(1.0, double(shares.size()));
      };
      text << "  \"" << name << "_balance\": " << balance << ",\n  \"" << name
           << "_missed_below_balance\": " << below(missed_) << ",\n  \"" << name
           << "_found_below_balance\": " << below(found_) << ",\n  \"" << name
           << "_missed_first_met_later\": " << late_missed_ / std::max(1.0, double(missed_.size()))
           << ",\n  \"" << name << "_recall_of_first_lap\": "
           << recall(double(found_.size()) - late_found_, double(missed_.size()) - late_missed_)
           << ",\n  \"" << name << "_recall_of_later_laps\": " << recall(late_found_, late_missed_)
           << ",\n  \"" << name << "_missed_by_share\": " << histogram(missed_) << ",\n  \"" << name
           << "_found_by_share\": " << histogram(found_) << ",\n";
      return text.str();
    }

   private:
    static double recall(double found, double missed) {
      return found / std::max(1.0, found + missed);
    }
    static std::string histogram(const std::vector<double>& shares) {
      constexpr int kBins = 20;
      std::array<int, kBins> counts{};
      for (const double share : shares) {
        ++counts[std::size_t(std::min(kBins - 1, static_cast<int>(share * kBins)))];
      }
      std::string text;
      for (const int count : counts) text += (text.empty() ? "[" : ", ") + std::to_string(count);
      return text + "]";
    }

    std::vector<double> found_, missed_;
    double late_found_ = 0.0, late_missed_ = 0.0;  ///< first met after the first lap
  };

  /// `isFound(x, y)`: whether a map has something within one cell of this one.
  template <class IsFound>
  Comparison compare(IsFound&& isFound) const {
    Comparison comparison;
    for (int y = 0; y < truth_.height; ++y) {
      for (int x = 0; x < truth_.width; ++x) {
        const std::size_t i = std::size_t(y) * std::size_t(truth_.width) + std::size_t(x);
        const Cell& cell = cells_[i];
        if (!truth_.occupied[i] || cell.ended == 0) continue;
        comparison.add(isFound(x, y), cell.ended / (cell.ended + cell.passed), cell.first_lap > 0);
      }
    }
    return comparison;
  }

 private:
  struct Cell {
    double ended = 0.0, passed = 0.0;
    int first_lap = 0;  ///< in which a beam first ended in it
  };

  Eigen::Vector2d toCells(const Eigen::Vector2d& place) const {
    return (place - truth_.origin) / truth_.resolution_m;
  }
  Cell* find(int x, int y) {
    if (x < 0 || y < 0 || x >= truth_.width || y >= truth_.height) return nullptr;
    return &cells_[std::size_t(y) * std::size_t(truth_.width) + std::size_t(x)];
  }

  const TrueOccupancy& truth_;
  std::vector<Cell> cells_;
};

}  // namespace hymm::core
