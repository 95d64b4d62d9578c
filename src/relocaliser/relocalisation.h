#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cekf/cekf_slam.h"
#include "relocaliser/filter_link.h"
#include "relocaliser/place_search.h"

namespace hymm::core {

/// Where an operator wants the vehicle to be looked for.
struct SearchWish {
  std::optional<PosePrior> around;  ///< map frame; nothing: anywhere
};

/// An order of the supervisor.
struct SearchOrder {
  std::uint64_t number = 0;  ///< grows from order to order
  double from_s = 0.0;       ///< stamp of the last scan that was in good order: T0
  double given_s = 0.0;      ///< stamp of the scan at which it was given
};

enum class SearchState {
  kIdle,       ///< no search is on
  kSearching,  ///< and does not believe itself yet
  kAccepted,   ///< the place was found, and the CEKF took it over
  kRefused,    ///< the place was found, and the CEKF refused it
  kFailed,     ///< the search could not begin
};

/// What a relocalisation has come to, as of a scan.
struct SearchReport {
  double time_s = 0.0;
  SearchState state = SearchState::kIdle;
  std::string reason;  ///< a sentence: what it does, why it has not found the place, what was said
  std::uint64_t order = 0;                    ///< that it is about
  bool anywhere = false;                      ///< without a prior
  std::optional<RelocaliserOutcome> outcome;  ///< of the scan, where it told something
  /// Of base_link, map frame: the heaviest mode, with the spread of all; where there are particles.
  std::optional<PosePrior> pose;
};

/// Finds the vehicle again, from the supervisor's order to the filter's return: takes the filter
/// back to the last scan in good order, searches around its estimate of that moment, and hands back
/// the way when it believes itself. The engine of the node `relocaliser`, live and offline. What it
/// takes waits until work() does it, a bounded piece at a time, and what comes of it does not
/// depend on when that is. Deterministic. Not thread-safe.
class Relocalisation {
 public:
  /// `filter` outlives it.
  Relocalisation(const RelocaliserConfig& config, const VehicleConfig& vehicle, FilterLink& filter);

  /// In order of time.
  void take(const MotionInput& input);
  /// What the filter took of a scan, and its pose then.
  void take(const ObservationSet& observations, const PoseEstimate& pose);

  /// A piece of what is to be done: one local map is made, one scan looked at in one of them, or a
  /// part of the search for rivals. False if nothing was left to do.
  bool work();

  /// The next order is to look there.
  void wish(const SearchWish& wish) { wish_ = wish; }

  /// Looks around the filter's estimate, or where was wished; anywhere if a search from the same
  /// scan came to nothing.
  void begin(const SearchOrder& order);
  /// The search is over: another filter is in charge, or none.
  void end();
  /// Another recording, or a new map, begins.
  void reset();

  const SearchReport& report() const { return report_; }
  /// Whether the report has changed since this was asked last.
  bool takeNews() { return std::exchange(is_news_, false); }
  const PlaceSearch& search() const { return search_; }
  std::uint64_t searches() const { return searches_; }

 private:
  void stop();
  void beginAround(const SearchWish& wish);
  void beginFromFilter();
  void beginAnywhere();
  void makeNextMap();
  void searchInMaps();
  void tellScan();
  void resume();
  std::optional<FilterKnowledge> askNear(const PosePrior& place, double way_m,
                                         std::string& problem);
  void startSearch(const SearchStart& start);
  void tell(SearchState state, std::string reason);

  RelocaliserConfig config_;
  FilterLink& filter_;
  PlaceSearch search_;
  std::deque<PoseEstimate> poses_;  ///< of the filter, the last history_s
  std::optional<SearchWish> wish_;  ///< for the next order
  std::uint64_t searches_ = 0;
  SearchOrder order_;
  bool is_elsewhere_ = false;  ///< an operator asked: the filter's pose is not to be believed
  std::vector<LandmarkEstimate> landmarks_;  ///< of which local maps are being made
  std::vector<Eigen::Vector2d> middles_;     ///< of local maps that are still to be made
  std::vector<LocalMap> maps_;               ///< made for a search anywhere
  Calibration calibration_;
  SearchReport report_;
  bool is_news_ = true;
};

}  // namespace hymm::core
