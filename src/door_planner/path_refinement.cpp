#include "door_planner/path_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "common/angles.h"

namespace hymm::core {
namespace {

/// By which a car may pass a corner further out than the path for a disc does.
constexpr std::array<double, 5> kOutwards_m{0.0, 0.3, 0.8, 1.6, 3.0};
constexpr int kHeadings = 12;  ///< that are tried where any will do
constexpr double kSame_m = 1e-6;
constexpr double kStraight_rad = 1e-3;
/// A corner may be left out by a curve that begins this many turning radii before its end.
constexpr double kSkippedRadii = 5.0;
constexpr std::size_t kSkippedCorners = 4;
/// A search gets at most this share of all iterations.
constexpr int kSearchesPerPlan = 4;
/// Deviation of the samples from the path, and of their headings from its own.
constexpr double kAside_m = 2.5;
constexpr double kTurned_rad = 0.6;
constexpr double kCorridorEvery_m = 0.5;

double headingOf(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return std::atan2(to.y() - from.y(), to.x() - from.x());
}

}  // namespace

struct PathRefinement::Run {
  const Request& request;
  Outcome& outcome;
  int iterations_left;
};

bool PathRefinement::Station::isReached() const {
  return std::any_of(options.begin(), options.end(),
                     [](const Option& option) { return option.cost < kNoPassing; });
}

std::size_t PathRefinement::Station::cheapest() const {
  const auto least =
      std::min_element(options.begin(), options.end(),
                       [](const Option& a, const Option& b) { return a.cost < b.cost; });
  return static_cast<std::size_t>(least - options.begin());
}

bool PathRefinement::isFree(const Pose2& pose, const Request& request) const {
  return (!request.allows || request.allows(pose.position())) && footprint_.isFree(graph_, pose);
}

void PathRefinement::addAnyHeading(const Eigen::Vector2d& place, double heading,
                                   const Request& request, Station& station) const {
  for (int i = 0; i < kHeadings; ++i) {
    const double turn = 2.0 * M_PI * i / kHeadings;
    const Pose2 pose{place.x(), place.y(), wrapAngle(heading + turn)};
    if (isFree(pose, request)) station.options.emplace_back(pose);
  }
}

void PathRefinement::addOptions(const Eigen::Vector2d& place, double heading,
                                const Eigen::Vector2d& outwards, const Request& request,
                                Station& station) const {
  for (const double away : kOutwards_m) {
    const Eigen::Vector2d moved = place + away * outwards;
    const Pose2 pose{moved.x(), moved.y(), heading};
    if (isFree(pose, request)) station.options.emplace_back(pose);
    if (outwards.isZero()) return;
  }
}

std::vector<PathRefinement::Station> PathRefinement::stationsAlong(
    const std::vector<PathPoint>& path, const Request& request) const {
  std::vector<Station> stations;
  for (const PathPoint& point : path) {
    const double step_m = stations.empty() ? 0.0 : (point.position - stations.back().place).norm();
    if (!stations.empty() && step_m < kSame_m) continue;
    const double along_m = stations.empty() ? 0.0 : stations.back().along_m + step_m;
    stations.push_back({point.position, along_m, {}});
  }
  if (stations.size() < 2) return stations;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    Station& here = stations[i];
    const bool is_first = i == 0, is_last = i + 1 == stations.size();
    const double in = is_first ? 0.0 : headingOf(stations[i - 1].place, here.place);
    const double out = is_last ? in : headingOf(here.place, stations[i + 1].place);
    if (is_first || is_last) {
      const std::optional<double>& given = is_first ? request.start_heading : request.goal_heading;
      if (given) {
        addOptions(here.place, *given, Eigen::Vector2d::Zero(), request, here);
      } else {
        addAnyHeading(here.place, out, request, here);
      }
      continue;
    }
    const double turn = wrapAngle(out - in), heading = wrapAngle(in + 0.5 * turn);
    // What the path goes round lies on the side that it turns to.
    const double side = std::abs(turn) < kStraight_rad ? 0.0 : turn > 0.0 ? 1.0 : -1.0;
    addOptions(here.place, heading, side * Eigen::Vector2d(std::sin(heading), -std::cos(heading)),
               request, here);
  }
  return stations;
}

/// Along a way from a free pose: K weighted, and of its changes of direction; infinite where the
/// car does not fit.
double PathRefinement::costOf(const std::vector<CarPose>& way, const Pose2& start,
                              const Request& request) const {
  double sum = 0.0;
  Eigen::Vector2d before = start.position();
  int ltr = graph_.locate(before);
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (!isFree(way[i].T_map_base, request)) return kNoPassing;
    const Eigen::Vector2d here = way[i].T_map_base.position();
    sum += graph_.integrateFromAny(ltr, before, here);
    if (sum == kNoPassing) return sum;
    if (i > 0 && way[i].is_backwards != way[i - 1].is_backwards) {
      sum += changeCost();
    }
    if (!graph_.ltr(ltr).triangle.contains(here)) ltr = graph_.locate(here);
    if (ltr == kNone) return kNoPassing;
    before = here;
  }
  return sum;
}

// Dynamic programming, step by step along the path: the cheapest free curve to each option of a
// station from any before it that is near enough. Curves are asked about in the order of what they
// cost at least.
bool PathRefinement::reach(std::vector<Station>& stations, std::size_t to,
                           const Request& request) const {
  struct Candidate {
    double at_least;
    std::size_t station, option;
    CarCurve curve;
  };
  for (Option& option : stations[to].options) {
    std::vector<Candidate> candidates;
    for (std::size_t from = to; from-- > 0 && to - from <= kSkippedCorners;) {
      const double between_m = stations[to].along_m - stations[from].along_m;
      if (from + 1 < to && between_m > kSkippedRadii * space_.turningRadius_m()) break;
      for (std::size_t k = 0; k < stations[from].options.size(); ++k) {
        const Option& begin = stations[from].options[k];
        if (begin.cost == kNoPassing) continue;
        CarCurve curve = space_.shortest(begin.pose, option.pose);
        const double least = begin.cost + graph_.leastPerMetre() * curve.length();
        candidates.push_back({least, from, k, std::move(curve)});
      }
    }
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.at_least < b.at_least; });
    for (const Candidate& candidate : candidates) {
      if (candidate.at_least >= option.cost) break;
      const Option& begin = stations[candidate.station].options[candidate.option];
      std::vector<CarPose> way = candidate.curve.poses(config_.step_m);
      const double cost = begin.cost + costOf(way, begin.pose, request);
      if (!(cost < option.cost)) continue;
      option.cost = cost;
      option.from_station = static_cast<int>(candidate.station);
      option.from_option = static_cast<int>(candidate.option);
      option.way = std::move(way);
    }
  }
  return stations[to].isReached();
}

/// LTRs that the path crosses between two stations, and those beside them.
std::vector<int> PathRefinement::corridorOf(const std::vector<Station>& stations, std::size_t from,
                                            std::size_t to) const {
  std::set<int> ltrs;
  for (std::size_t i = from; i < to; ++i) {
    const Eigen::Vector2d along = stations[i + 1].place - stations[i].place;
    const int parts = std::max(1, static_cast<int>(std::ceil(along.norm() / kCorridorEvery_m)));
    for (int k = 0; k <= parts; ++k) {
      const int ltr = graph_.locate(stations[i].place + along * k / parts);
      if (ltr == kNone) continue;
      ltrs.insert(ltr);
      for (const int beside : graph_.ltr(ltr).neighbours) {
        if (beside != kNone) ltrs.insert(beside);
      }
    }
  }
  return {ltrs.begin(), ltrs.end()};
}

CarSpace::Maze PathRefinement::mazeBetween(const std::vector<Station>& stations, std::size_t from,
                                           std::size_t to, const Request& request) const {
  CarSpace::Maze maze;
  const std::vector<int> corridor = corridorOf(stations, from, to);
  maze.is_free = [this, corridor, &request](const Pose2& pose) {
    const bool is_inside = std::any_of(corridor.begin(), corridor.end(), [&](int ltr) {
      return graph_.ltr(ltr).triangle.contains(pose.position());
    });
    return is_inside && isFree(pose, request);
  };
  maze.sample = [&stations, from, to](RandomGenerator& generator) {
    const double at = sampleUniform(generator, stations[from].along_m, stations[to].along_m);
    std::size_t i = from;
    while (i + 1 < to && stations[i + 1].along_m < at) ++i;
    const Eigen::Vector2d along = (stations[i + 1].place - stations[i].place).normalized();
    const Eigen::Vector2d aside(sampleNormal(generator, kAside_m),
                                sampleNormal(generator, kAside_m));
    const Eigen::Vector2d place = stations[i].place + (at - stations[i].along_m) * along + aside;
    const double heading = std::atan2(along.y(), along.x()) + sampleNormal(generator, kTurned_rad);
    return Pose2{place.x(), place.y(), wrapAngle(heading)};
  };
  maze.low = maze.high = stations[from].place;
  for (const int ltr : corridor) {
    for (const Eigen::Vector2d& corner : graph_.ltr(ltr).view.corners) {
      maze.low = maze.low.cwiseMin(corner);
      maze.high = maze.high.cwiseMax(corner);
    }
  }
  return maze;
}

/// By RRT* from the cheapest option of the last station that was reached.
bool PathRefinement::searchTo(std::vector<Station>& stations, std::size_t to, Run& run) const {
  std::size_t from = to - 1;
  while (from > 0 && !stations[from].isReached()) --from;
  const std::size_t begin_option = stations[from].cheapest();
  const Option& begin = stations[from].options[begin_option];
  const int iterations = std::min(run.iterations_left, config_.iterations / kSearchesPerPlan);
  if (stations[to].options.empty() || iterations <= 0) return false;
  ++run.outcome.searches;
  run.iterations_left -= iterations;
  std::vector<Pose2> goals;
  for (const Option& option : stations[to].options) goals.push_back(option.pose);
  const auto found =
      space_.search(begin.pose, goals, mazeBetween(stations, from, to, run.request),
                    {iterations, static_cast<std::uint64_t>(config_.seed), run.request.stop});
  if (!found) return false;

  Option end(found->back());
  for (std::size_t i = 1; i < found->size(); ++i) {
    const std::vector<CarPose> poses =
        space_.shortest((*found)[i - 1], (*found)[i]).poses(config_.step_m);
    end.way.insert(end.way.end(), poses.begin(), poses.end());
  }
  end.cost = begin.cost + costOf(end.way, begin.pose, run.request);
  if (end.cost == kNoPassing) return false;
  end.from_station = static_cast<int>(from);
  end.from_option = static_cast<int>(begin_option);
  stations[to].options.push_back(std::move(end));
  return true;
}

std::vector<CarPose> PathRefinement::collect(const std::vector<Station>& stations) {
  std::vector<const Option*> chain{&stations.back().options[stations.back().cheapest()]};
  while (chain.back()->from_station != kNone) {
    const Option& passed = *chain.back();
    chain.push_back(
        &stations[std::size_t(passed.from_station)].options[std::size_t(passed.from_option)]);
  }
  std::vector<CarPose> poses{{chain.back()->pose, false}};
  for (auto passed = chain.rbegin(); passed != chain.rend(); ++passed) {
    poses.insert(poses.end(), (*passed)->way.begin(), (*passed)->way.end());
  }
  return poses;
}

PathRefinement::Outcome PathRefinement::refine(const std::vector<PathPoint>& path,
                                               const Request& request) const {
  Outcome outcome;
  std::vector<Station> stations = stationsAlong(path, request);
  if (stations.size() < 2) {
    outcome.failure = "start and goal are the same place";
    return outcome;
  }
  for (const auto& [station, name] :
       {std::make_pair(0, "start"),
        std::make_pair(static_cast<int>(stations.size()) - 1, "goal")}) {
    if (!stations[std::size_t(station)].options.empty()) continue;
    outcome.failure = std::string("the vehicle, with its length, does not fit at the ") + name;
    return outcome;
  }
  for (Option& option : stations.front().options) option.cost = 0.0;
  Run run{request, outcome, config_.iterations};
  for (std::size_t to = 1; to < stations.size(); ++to) {
    if (request.stop && request.stop()) {
      outcome.failure = "the time for it was over";
      return outcome;
    }
    if (reach(stations, to, request)) continue;
    // The next corners may be reached past this one.
    const bool is_last = to + 1 == stations.size();
    const bool was_reached = stations[to - 1].isReached();
    if (was_reached && !is_last) continue;
    searchTo(stations, to, run);
  }
  if (stations.back().isReached()) {
    outcome.poses = collect(stations);
    shorten(outcome.poses, request);
  } else {
    outcome.failure = "no way for its turning radius was found beside the path";
  }
  return outcome;
}

}  // namespace hymm::core
