#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <hymm/EvaluateInformation.h>
#include <hymm/FilterPose.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LevelSet.h>
#include <hymm/SuggestExploration.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>

#include "information_map/information_map.h"
#include "pipeline/filter_life.h"
#include "pipeline/latency_histogram.h"
#include "ros/cause_log.h"
#include "ros/dense_map_mirror.h"
#include "ros/traffic_meter.h"

namespace hymm {

/// The node `information_map`: takes landmark maps, publishes their level sets, and answers what
/// poses are worth and where to explore. A thread of its own computes; of maps that come meanwhile
/// only the newest is kept, and where an update takes its time the sets move along with the
/// landmarks until they are computed.
class InformationMapNode {
 public:
  /// Throws ConfigError if the parameters are unusable.
  InformationMapNode(const core::InformationMapConfig& config, const core::VehicleConfig& vehicle);
  ~InformationMapNode();

 private:
  /// A landmark map that waits for the worker.
  struct Waiting {
    core::LandmarkMap map;
    core::Pose2 T_map_base;
    double taken_s = 0.0;      ///< by the steady clock
    bool begins_anew = false;  ///< it, or one passed over for it, is the first of another filter
  };

  void takeMap(const LandmarkMapConstPtr& message);
  void takePose(const FilterPoseConstPtr& message);
  void work();
  void compute(const Waiting& next);
  void takeDenseMap();
  void note(const core::LevelSetUpdate& update, double ms);
  void publish(const core::LevelSets& sets, bool complete);
  std::string delaysText() const;
  void greet(const ros::SingleSubscriberPublisher& subscriber);
  bool evaluate(EvaluateInformation::Request& request, EvaluateInformation::Response& response);
  bool suggest(SuggestExploration::Request& request, SuggestExploration::Response& response);
  std::optional<double> mapAge_s() const;
  void summarize(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  std::string map_frame_;
  CauseLog causes_;
  TrafficMeter traffic_;
  DenseMapMirror dense_map_;

  std::mutex engine_mutex_;  ///< over the engine; held while it computes
  core::InformationMap information_;

  std::mutex mutex_;  ///< over what follows; never held while the engine computes
  std::condition_variable changed_;
  core::FilterLife filter_;  ///< by its maps
  std::optional<Waiting> waiting_;
  std::optional<FilterPose> pose_;
  std::vector<LevelSet> published_;  ///< last, of each value
  bool stopping_ = false;
  std::size_t skipped_maps_ = 0, moved_sets_ = 0;
  double last_ms_ = 0.0, worst_ms_ = 0.0;  ///< wall time of an update; worst since last diagnosis
  core::LevelSetUpdate last_update_;
  core::InformationMap::Counts counts_;
  core::LatencyHistogram delays_;  ///< from the arrival of a map to its sets

  ros::Publisher level_sets_, islands_markers_;
  ros::Subscriber maps_, poses_;
  ros::CallbackQueue calls_;  ///< of services, which wait for the engine
  ros::ServiceServer evaluate_service_, suggest_service_;
  ros::AsyncSpinner call_spinner_{1, &calls_};
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer diagnostics_timer_;
  std::thread worker_;
};

}  // namespace hymm
