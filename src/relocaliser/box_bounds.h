#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relocaliser/density_map.h"
#include "relocaliser/point_bounds.h"
#include "relocaliser/point_groups.h"

namespace hymm::core {

/// Poses of the vehicle: where the middle of the points comes to lie, within a square, and the
/// heading.
struct PoseBox {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
};

/// Bounds on what observed points together are worth, as a log likelihood, at any pose of a box:
/// each point takes its best value on its own. Boxes of a level are half as large, along each axis,
/// as those of the level before.
class BoxBounds {
 public:
  /// One point and one landmark at least.
  BoxBounds(const std::vector<LocalLandmark>& landmarks, const std::vector<ObservedPoint>& points,
            double clutter_per_m2);

  /// Of the points, base frame. Turned about it, they move least.
  const Eigen::Vector2d& middle() const { return middle_; }
  /// A point is no farther from the middle.
  double longest_m() const { return longest_m_; }
  /// Farther from this box no landmark has an effect on a point.
  Eigen::AlignedBox2d landmarkBox() const;

  /// Half of the side of a square within which, with some headings, points move by up to
  /// `radius_m`; and half of the interval of headings: it leaves them half of the motion.
  static double halfSide_m(double radius_m);
  double halfYaw_rad(double radius_m) const;

  /// The first level is of boxes in which points move by up to `coarsest_m`; their headings may be
  /// fewer than that allows.
  void makeLevels(double coarsest_m, double half_yaw_rad);
  /// Does a step of what has to be done before the first bound; gives how long it was, in steps of
  /// some nanoseconds. Nothing if all is done.
  std::optional<std::size_t> prepare();

  std::size_t levels() const { return levels_.size(); }
  double half_m(std::size_t level) const { return levels_[level].half_m; }
  double half_yaw_rad(std::size_t level) const { return levels_[level].half_yaw_rad; }
  /// Whether bounds are looked up; else they are computed from the landmarks.
  bool isTabled(std::size_t level) const { return levels_[level].isTabled(); }

  /// The most that all points can be worth in a box, which is a part of the one of the level before
  /// whose bound was told last; -inf as soon as it is clear that it is no more than `needed`.
  double bound(std::size_t level, const PoseBox& box, double needed);
  /// What they are worth at the pose in the middle of the box.
  double valueAt(const PoseBox& box);
  /// Bounds on points or groups of points that were looked up or computed.
  std::size_t used() const { return used_; }

 private:
  /// The points of one class in a group.
  struct Part {
    std::size_t deviation = 0;
    double count = 0.0;
  };
  struct Level {
    double half_m = 0.0;
    double half_yaw_rad = 0.0;
    PointBounds::Tables tables;            ///< without values: bounds are computed
    std::vector<PointGroup> groups;        ///< that are bounded together
    std::vector<Part> parts;               ///< of the groups
    std::vector<std::size_t> first_parts;  ///< by group, and the end
    std::vector<std::size_t> part_of;      ///< by point

    bool isTabled() const { return !tables.values.empty(); }
  };
  struct LookedUp {
    double value = 0.0;  ///< of all the group's points
    std::int64_t cell = 0;
  };

  PointBounds makeBounds(const std::vector<LocalLandmark>& landmarks,
                         const std::vector<ObservedPoint>& points, double clutter_per_m2);
  void takePoints(const std::vector<ObservedPoint>& points);
  static double movesOf(const Level& level, const PointGroup& group);
  void divideGroups(Level& level) const;
  std::vector<double> mostOfAll() const;
  bool mayExceed(const Level& level, const PoseBox& box, const std::vector<double>& most,
                 double needed, double& sum);
  double boundOfPoint(const Level& level, const PointGroup& group, const Eigen::Vector2d& place,
                      std::int64_t cell) const;
  bool mayExceedByClass(const Level& level, double needed, double& sum);
  double sumUp(const Level& level, const std::vector<double>& most, std::vector<double>& sums);

  std::map<double, std::size_t> index_;  ///< of the points' deviations
  PointBounds bounds_;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();
  std::vector<ArmPoint> points_;
  double longest_m_ = 0.0;
  std::vector<Level> levels_;
  std::size_t filled_ = 0;                 ///< levels
  std::vector<double> most_;               ///< what the points before each are worth, anywhere
  std::vector<std::vector<double>> sums_;  ///< the same in a box, by level
  std::vector<double> worth_;              ///< of the box: a point's, by part
  std::vector<LookedUp> looked_up_;        ///< the same by group
  std::size_t used_ = 0;
};

}  // namespace hymm::core
