#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/random.h"
#include "perception/observation.h"
#include "relocaliser/convergence.h"
#include "relocaliser/helical_region.h"
#include "relocaliser/local_map.h"
#include "relocaliser/motion_since.h"
#include "relocaliser/observed_bound.h"
#include "relocaliser/particle_filter.h"
#include "relocaliser/recent_scans.h"
#include "relocaliser/relocaliser_config.h"

namespace hymm::core {

struct RivalQuestion;

/// What a scan told.
struct RelocaliserOutcome {
  double time_s = 0.0;
  Pose2 T_map_base;  ///< mean of the heaviest mode
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();      ///< of it, map axes; without what the map itself is off by
  std::vector<ParticleMode> modes;  ///< local frame, the heaviest first
  std::size_t particles = 0;
  double effective_number = 0.0;
  bool resampled = false;
  Explanation explanation;    ///< of this scan by the heaviest mode
  int held_scans = 0;         ///< in a row without doubt
  bool converged = false;     ///< without doubt, held, and no rival
  bool is_unsettled = false;  ///< all else speaks for it, but a rival has not been looked for yet
  std::string doubt;          ///< why it has not converged, in words
};

/// Finds the vehicle in a map of landmarks by a particle filter that associates nothing. Runs from
/// begin() until somebody begins anew; deterministic for a given generator. Not thread-safe.
class Relocaliser {
 public:
  /// Counts since construction.
  struct Counts {
    std::size_t scans = 0;
    std::size_t refused_scans = 0;   ///< not later than the last, or without finite observations
    std::size_t refused_motion = 0;  ///< not finite, or not later than the last
    std::size_t poor_scans = 0;      ///< with too few observations to begin
    std::size_t begun = 0;
    std::size_t rivals = 0;  ///< times that another place explained the scans as well
  };

  Relocaliser(const RelocaliserConfig& config, const VehicleConfig& vehicle,
              const Calibration& calibration, RandomGenerator generator);

  /// Looks for the vehicle within the prior of `map` from `time_s` on. The motion until the first
  /// scan widens the prior.
  void begin(LocalMap map, double time_s);
  /// The same without a prior: the vehicle may be anywhere among the landmarks.
  void beginGlobally(LocalMap map, double time_s);

  /// False, and nothing changes, for an input that is refused.
  bool process(const MotionInput& input);
  /// Nothing before begin(), and for a set that is refused or too poor to begin with.
  std::optional<RelocaliserOutcome> process(const ObservationSet& set);
  /// The same without looking for a rival, which takes long: an outcome that is unsettled has to be
  /// settled before the next input.
  std::optional<RelocaliserOutcome> look(const ObservationSet& set);
  /// Of the last look(): whether a place in map() is a rival.
  void settle(RelocaliserOutcome& outcome, bool has_rival);

  /// How well the last scans together are explained from a place (local frame), as a log likelihood
  /// that is zero where nothing is explained.
  double logLikelihoodAt(const Pose2& place) const;
  /// Whether a place in `map` (of another search, or of this one) explains the last scans nearly as
  /// well as `T_map_believed` does in this one, elsewhere than there.
  RivalQuestion rivalQuestion(const LocalMap& map, const Pose2& T_map_believed) const;
  const ParticleSet& particles() const { return filter_.particles(); }
  const LocalMap& map() const { return map_; }
  /// Where the vehicle may be by its prior and the motion up to the last scan, local frame;
  /// nothing: anywhere.
  const std::optional<PosePrior>& prior() const { return prior_; }
  const Counts& counts() const { return counts_; }

 private:
  bool isGlobal() const { return !prior_; }
  void start(const std::vector<ObservedPoint>& points);
  RelocaliserOutcome judge(const std::vector<ObservedPoint>& points, const Pose2& T_base_sensor);
  HelicalRegions regionsOf(const std::vector<ObservedPoint>& points) const;
  /// Of what can be seen from where the particles are.
  std::vector<LocalLandmark> visibleLandmarks(const std::vector<ObservedPoint>& points) const;
  double viewArea_m2() const;

  RelocaliserConfig config_;
  RandomGenerator generator_;
  ParticleFilter filter_;
  MotionSince motion_;
  RecentScans recent_;
  LocalMap map_;
  ObservedBound bound_;
  std::optional<PosePrior> prior_;  ///< local frame, moved along with the vehicle
  bool begun_ = false;
  bool started_ = false;  ///< particles are there
  std::optional<double> time_s_;
  HeldEvidence held_;
  bool is_unrivalled_ = false;  ///< since the evidence is held
  Counts counts_;
};

}  // namespace hymm::core
