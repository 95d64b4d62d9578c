#pragma once

#include <filesystem>
#include <map>
#include <utility>

#include <hymm/LevelSet.h>
#include <ros/node_handle.h>

namespace hymm {

/// Keeps the level sets that the node `information_map` tells last, and writes them as an offline
/// run does: level_sets.csv. Where that node does not run, nothing is written.
class LevelSetRecord {
 public:
  /// `folder`: of the results; it exists.
  explicit LevelSetRecord(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void subscribe(ros::NodeHandle& handle);

  /// Throws OutputError.
  void write() const;

 private:
  static constexpr std::size_t kMostSets = 64;  ///< what follows is not kept

  void takeSet(const LevelSet& message);

  std::filesystem::path folder_;
  std::map<double, LevelSet> sets_;  ///< by value
  ros::Subscriber subscriber_;
};

}  // namespace hymm
