#include "relocaliser/rival_search.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "relocaliser/relocaliser.h"

namespace hymm::core {
namespace {

constexpr double kView_m2 = 1400.0;
constexpr double kMargin = 12.0;
constexpr std::size_t kUnlimited = 1000000000;
const Pose2 kCopied{0.0, 80.0, 1.0};  ///< from the first landmarks to their copy

using Landmarks = std::vector<LocalLandmark>;

/// Trees strewn before the vehicle.
Landmarks strewn(RandomGenerator& generator, int count) {
  Landmarks landmarks;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d place(sampleUniform(generator, 5.0, 40.0),
                                sampleUniform(generator, -15.0, 15.0));
    landmarks.push_back({i, place, 1e-3 * Eigen::Matrix2d::Identity()});
  }
  return landmarks;
}

/// The same and a copy of them, each moved by an error of this deviation.
Landmarks withCopy(Landmarks landmarks, RandomGenerator& generator, double error_m) {
  const std::size_t count = landmarks.size();
  for (std::size_t i = 0; i < count; ++i) {
    LocalLandmark copy = landmarks[i];
    copy.id += 1000;
    copy.position = kCopied * copy.position + Eigen::Vector2d(sampleNormal(generator, error_m),
                                                              sampleNormal(generator, error_m));
    landmarks.push_back(copy);
  }
  return landmarks;
}

/// What ten scans show of landmarks from the origin: `count` points, some clutter among them.
std::vector<ObservedPoint> seen(const Landmarks& landmarks, RandomGenerator& generator,
                                std::size_t count, double clutter_share) {
  std::vector<ObservedPoint> points;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d error(sampleNormal(generator, 0.05), sampleNormal(generator, 0.05));
    Eigen::Vector2d place = landmarks[k % landmarks.size()].position + error;
    if (sampleUniform(generator, 0.0, 1.0) < clutter_share) {
      place = {sampleUniform(generator, 5.0, 40.0), sampleUniform(generator, -15.0, 15.0)};
    }
    const double deviation_m = roundedUpDeviation(sampleUniform(generator, 0.15, 0.4));
    points.push_back({place.cast<float>(), deviation_m, place.norm()});
  }
  return points;
}

double likelihoodAt(const Pose2& pose, const Landmarks& landmarks,
                    const std::vector<ObservedPoint>& points) {
  return logLikelihoodAt(pose, landmarks, points, kView_m2, {});
}

RivalQuestion question(const Landmarks& landmarks, const std::vector<ObservedPoint>& points,
                       double log_likelihood, const std::optional<PosePrior>& prior = std::nullopt,
                       std::size_t most_bounds = kUnlimited) {
  return {landmarks, points, kView_m2, {}, prior, 3.0, {}, 1.5, 0.2, log_likelihood, most_bounds};
}

RivalAnswer::Kind ask(const Landmarks& landmarks, const std::vector<ObservedPoint>& points,
                      double log_likelihood, const std::optional<PosePrior>& prior = std::nullopt,
                      std::size_t most_bounds = kUnlimited) {
  return findRival(question(landmarks, points, log_likelihood, prior, most_bounds)).kind;
}

/// What comes of pieces of so many steps, and how many it takes.
std::pair<RivalAnswer, std::size_t> askInPieces(const RivalQuestion& question, std::size_t steps) {
  RivalSearch search(question);
  for (std::size_t pieces = 1;; ++pieces) {
    if (const auto answer = search.work(steps)) return {*answer, pieces};
  }
}

TEST(RivalSearch, NeverMissesACopyHoweverNarrowItsPeak) {
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    RandomGenerator generator(seed);
    const int count = 4 + static_cast<int>(seed % 5) * 4;
    const Landmarks one = strewn(generator, count);
    const auto points =
        seen(one, generator, 30 + 30 * (seed % 4), 0.1 * static_cast<double>(seed % 3));
    const Landmarks two = withCopy(one, generator, 0.0);
    EXPECT_EQ(ask(two, points, likelihoodAt({}, two, points) - kMargin), RivalAnswer::Kind::kRival)
        << "seed " << seed;
  }
}

TEST(RivalSearch, FindsNoneWhereLandmarksAreUnique) {
  for (std::uint64_t seed = 0; seed < 15; ++seed) {
    RandomGenerator generator(seed);
    const Landmarks landmarks = strewn(generator, 20);
    const auto points = seen(landmarks, generator, 100, 0.1);
    EXPECT_EQ(ask(landmarks, points, likelihoodAt({}, landmarks, points) - kMargin),
              RivalAnswer::Kind::kNoRival)
        << "seed " << seed;
  }
}

// What a search by samples finds, narrowed down from the copy's exact place, is a lower bound of
// the greatest likelihood: where the answer is that there is none, no sample may say otherwise.
TEST(RivalSearch, IsNeverContradictedBySamplesAroundCopiesThatAreNotExact) {
  int none = 0, rivals = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomGenerator generator(100 + seed);
    const Landmarks one = strewn(generator, 8);
    const auto points = seen(one, generator, 60, 0.1);
    const Landmarks two = withCopy(one, generator, 0.05 * static_cast<double>(seed % 10));
    Pose2 best = kCopied;
    double greatest = likelihoodAt(best, two, points);
    for (int i = 0; i < 1500; ++i) {
      const double share = std::pow(0.5, i / 250);
      const Pose2 step{sampleNormal(generator, 0.1 * share), sampleNormal(generator, 0.1 * share),
                       sampleNormal(generator, 0.01 * share)};
      const double value = likelihoodAt(best * step, two, points);
      if (value <= greatest) continue;
      greatest = value;
      best = best * step;
    }
    const double of_believed = likelihoodAt({}, two, points);
    // Boxes of a few millimetres cannot tell what is nearer to the margin than some nats.
    if (greatest > of_believed - kMargin) {
      EXPECT_EQ(ask(two, points, of_believed - kMargin), RivalAnswer::Kind::kRival);
      ++rivals;
    }
    if (greatest < of_believed - 2.0 * kMargin) {
      EXPECT_EQ(ask(two, points, of_believed - kMargin), RivalAnswer::Kind::kNoRival);
      ++none;
    }
  }
  EXPECT_GE(none, 3);
  EXPECT_GE(rivals, 3);
}

TEST(RivalSearch, LooksWithinThePriorOnly) {
  RandomGenerator generator(1);
  const Landmarks one = strewn(generator, 12);
  const auto points = seen(one, generator, 80, 0.0);
  const Landmarks two = withCopy(one, generator, 0.0);
  const double needed = likelihoodAt({}, two, points) - kMargin;
  const auto askWithin = [&](double deviation_m, double deviation_rad) {
    PosePrior prior;
    prior.covariance = Eigen::Vector3d(deviation_m * deviation_m, deviation_m * deviation_m,
                                       deviation_rad * deviation_rad)
                           .asDiagonal();
    return ask(two, points, needed, prior);
  };
  EXPECT_EQ(askWithin(20.0, 0.5), RivalAnswer::Kind::kNoRival);
  EXPECT_EQ(askWithin(40.0, 0.2), RivalAnswer::Kind::kNoRival);
  EXPECT_EQ(askWithin(40.0, 0.5), RivalAnswer::Kind::kRival);
}

TEST(RivalSearch, SaysSoWhenItsBoundsAreUsedUp) {
  RandomGenerator generator(1);
  const Landmarks landmarks = strewn(generator, 20);
  const auto points = seen(landmarks, generator, 100, 0.0);
  const double needed = likelihoodAt({}, landmarks, points) - kMargin;
  EXPECT_EQ(ask(landmarks, points, needed, std::nullopt, 1000), RivalAnswer::Kind::kUndecided);
}

// As many landmarks as a local map takes, seen ten times, a fifth of the points being clutter.
TEST(RivalSearch, DecidesAboutAHundredLandmarksWithinItsBounds) {
  RandomGenerator generator(1);
  const Landmarks landmarks = strewn(generator, 100);
  const auto points = seen(landmarks, generator, 470, 0.2);
  const double needed = likelihoodAt({}, landmarks, points) - kMargin;
  const auto most_bounds = static_cast<std::size_t>(RelocaliserConfig().rival_bounds);
  EXPECT_EQ(ask(landmarks, points, needed, std::nullopt, most_bounds), RivalAnswer::Kind::kNoRival);
}

TEST(RivalSearch, AnswersTheSameInPiecesOfAnySize) {
  RandomGenerator generator(3);
  const Landmarks one = strewn(generator, 12), two = withCopy(one, generator, 0.0);
  const auto points = seen(one, generator, 60, 0.1);
  PosePrior prior;
  prior.covariance = Eigen::Vector3d(100.0, 100.0, 0.04).asDiagonal();
  const double of_one = likelihoodAt({}, one, points) - kMargin;
  const double of_two = likelihoodAt({}, two, points) - kMargin;
  const std::vector<std::pair<RivalQuestion, RivalAnswer::Kind>> questions{
      {question(one, points, of_one), RivalAnswer::Kind::kNoRival},
      {question(one, points, of_one, prior), RivalAnswer::Kind::kNoRival},
      {question(two, points, of_two), RivalAnswer::Kind::kRival},
      {question(one, points, of_one, std::nullopt, 20000), RivalAnswer::Kind::kUndecided},
      {question(one, {}, 1.0), RivalAnswer::Kind::kNoRival}};
  for (const auto& [question, kind] : questions) {
    const RivalAnswer at_once = findRival(question);
    EXPECT_EQ(at_once.kind, kind);
    for (const std::size_t steps : {1U, 997U, 50000U}) {
      const RivalAnswer answer = askInPieces(question, steps).first;
      EXPECT_EQ(answer.kind, at_once.kind) << steps;
      EXPECT_EQ(answer.bounds, at_once.bounds) << steps;
    }
  }
}

TEST(RivalSearch, DoesNoMoreInAPieceThanItIsAllowed) {
  RandomGenerator generator(3);
  const Landmarks landmarks = strewn(generator, 12);
  const auto points = seen(landmarks, generator, 60, 0.1);
  const RivalQuestion asked =
      question(landmarks, points, likelihoodAt({}, landmarks, points) - kMargin);
  const auto [answer, pieces] = askInPieces(asked, 10000);
  // A bound is a step, and a box that is begun is finished.
  EXPECT_GE(pieces, answer.bounds / (10000 + points.size()));
  EXPECT_GT(pieces, 20U);
  EXPECT_GT(askInPieces(asked, 1000).second, 5 * pieces);
}

TEST(RivalSearch, GoesOnWhereItIsMovedTo) {
  RandomGenerator generator(3);
  const Landmarks landmarks = strewn(generator, 12);
  const auto points = seen(landmarks, generator, 60, 0.1);
  const RivalQuestion asked =
      question(landmarks, points, likelihoodAt({}, landmarks, points) - kMargin);
  RivalSearch first(asked);
  for (int i = 0; i < 20; ++i) ASSERT_FALSE(first.work(10000));
  RivalSearch second(std::move(first));
  const auto answer = second.work(kUnlimited);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->bounds, findRival(asked).bounds);
  EXPECT_EQ(second.work(1)->bounds, answer->bounds);  // and keeps its answer
}

TEST(RivalSearch, CallsEveryPlaceARivalOfOneThatExplainsNothing) {
  RandomGenerator generator(1);
  const Landmarks landmarks = strewn(generator, 5);
  EXPECT_EQ(ask(landmarks, seen(landmarks, generator, 10, 0.0), -1.0), RivalAnswer::Kind::kRival);
  EXPECT_EQ(ask({}, seen(landmarks, generator, 10, 0.0), 1.0), RivalAnswer::Kind::kNoRival);
  EXPECT_EQ(ask(landmarks, {}, 1.0), RivalAnswer::Kind::kNoRival);
}

/// A drive among `landmarks`, of which the first `count` are where it is: whether it converged.
bool converges(const Landmarks& landmarks, std::size_t count, std::uint64_t seed, double rate_hz) {
  RandomGenerator generator(seed);
  LocalMap map;
  map.landmarks = landmarks;
  RelocaliserConfig config;
  config.global_particles = 20000;
  Relocaliser relocaliser(config, {}, {}, RandomGenerator(seed));
  relocaliser.beginGlobally(map, 0.0);
  Pose2 pose;
  for (double time_s = 0.0; time_s < 6.0;) {
    relocaliser.process(TwistInput{time_s, 2.0, 0.0, 0.0, std::nullopt});
    time_s += 1.0 / rate_hz;
    pose.x_m += 2.0 / rate_hz;
    ObservationSet set{time_s, {}, {}};
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector2d p = inverse(pose) * landmarks[i].position;
      Observation observation;
      observation.range_m = p.norm() + sampleNormal(generator, 0.05);
      observation.bearing_rad = std::atan2(p.y(), p.x()) + sampleNormal(generator, 0.004);
      observation.covariance = Eigen::Vector2d(25e-4, 16e-6).asDiagonal();
      if (p.norm() > 28.0 || std::abs(observation.bearing_rad) > 1.55) continue;
      set.observations.push_back(observation);
    }
    const auto outcome = relocaliser.process(set);
    if (outcome && outcome->converged) return true;
  }
  return false;
}

TEST(Relocaliser, NeverConvergesBetweenExactCopies) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    RandomGenerator generator(seed);
    const Landmarks one = strewn(generator, seed % 2 == 0 ? 10 : 20);
    const Landmarks two = withCopy(one, generator, 0.0);
    const double rate_hz = seed % 3 == 0 ? 2.0 : 5.0;
    EXPECT_FALSE(converges(two, one.size(), seed, rate_hz)) << "seed " << seed;
  }
}

TEST(Relocaliser, ConvergesWhereTheSameLandmarksHaveNoCopy) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    RandomGenerator generator(seed);
    const Landmarks one = strewn(generator, 20);
    EXPECT_TRUE(converges(one, one.size(), seed, 5.0)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hymm::core
