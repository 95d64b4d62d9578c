#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <string>

#include <hymm/FilterPose.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkUpdate.h>

#include "pipeline/filter_life.h"
#include "ros/headed_scan.h"

namespace hymm {

/// What came of one scan on four topics.
struct PairedScan {
  LandmarkUpdate::ConstPtr update;  ///< always
  FilterPose::ConstPtr pose;        ///< null: it got lost; nothing but the update counts
  LandmarkMap::ConstPtr map;        ///< of the update's version, if it was announced
  HeadedScan::ConstPtr scan;        ///< null: it did not come, or there is none
};

/// Brings together what belongs to one scan: itself, the filter's pose of it, what changed of the
/// landmarks, and the whole landmark map where the update announces one; by stamp and version,
/// whatever the order in which the topics bring them. Each topic by itself is in order. What does
/// not come within a few seconds is given up and counted, and what waits for the last words of a
/// filter that has been started anew at once; buffers are bounded. Times are of any clock that runs
/// with the wall.
class ScanPairing {
 public:
  struct Counts {
    std::size_t unused_scans = 0;   ///< without a pose: the filter refused them
    std::size_t missing_scans = 0;  ///< poses whose scan did not come
    std::size_t missing_maps = 0;   ///< announced, but they did not come
    std::size_t missing_poses = 0;  ///< updates without a pose, or poses without an update
    std::size_t overflows = 0;      ///< messages dropped from full buffers
    std::size_t dropped_scans = 0;  ///< scans among them
  };

  void add(const HeadedScan::ConstPtr& scan);
  void add(const FilterPose::ConstPtr& pose, double now_s);
  void add(const LandmarkUpdate::ConstPtr& update);
  void add(const LandmarkMap::ConstPtr& map);

  /// The next scan of which all has come, or is given up. `has_scans`: whether anybody publishes
  /// any; else none is waited for.
  std::optional<PairedScan> next(double now_s, bool has_scans);

  /// Forgets all that waits.
  void clear();

  std::size_t waiting() const { return poses_.size(); }
  const Counts& counts() const { return counts_; }

 private:
  struct Arrived {
    FilterPose::ConstPtr pose;
    double at_s;
    bool begins_anew;  ///< the filter, or its map
  };
  enum class Search { kFound, kWaiting, kNone };

  std::optional<PairedScan> takeLoneUpdate();
  Search findUpdate(bool is_late);
  Search findMap(const LandmarkUpdate& update, bool is_late, LandmarkMap::ConstPtr& map) const;
  Search findScan(const ros::Time& stamp, bool is_late, HeadedScan::ConstPtr& scan) const;
  void takeMap(const LandmarkMap::ConstPtr& map);
  void takeScan(const HeadedScan::ConstPtr& scan);
  void forgetScansBeforeJump();

  std::deque<HeadedScan::ConstPtr> scans_;
  ros::Time newest_stamp_;               ///< of the scan that came last
  std::set<std::string> newest_frames_;  ///< that brought scans of that stamp
  std::deque<Arrived> poses_;
  std::deque<LandmarkUpdate::ConstPtr> updates_;
  std::deque<LandmarkMap::ConstPtr> maps_;
  core::FilterLife filter_;  ///< by the poses
  Counts counts_;
};

}  // namespace hymm
