#include "information_map/information_evaluator.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/error.h"
#include "random_landmarks.h"

namespace hymm::core {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kCell_m = 15.0;

InformationConfig roundLooking() {
  InformationConfig config;
  config.sensor.range_m = 20.0;
  config.sensor.min_range_m = 0.1;
  config.sensor.field_of_view_rad = 2.0 * kPi;
  return config;
}

VectorXd measurementOf(const VectorXd& state, Index landmarks) {
  VectorXd z(2 * landmarks);
  for (Index i = 0; i < landmarks; ++i) {
    const Vector2d d = state.segment<2>(3 + 2 * i) - state.head<2>();
    z.segment<2>(2 * i) << d.norm(), std::atan2(d.y(), d.x()) - state(2);
  }
  return z;
}

/// What an EKF over pose and landmarks knows of the pose after one look, by numeric Jacobians of
/// range and bearing.
Matrix3d posteriorOfFilter(const Pose2& pose, const std::vector<Vector2d>& places,
                           const MatrixXd& P, const ExpectedSensor& sensor) {
  const auto n = Index(places.size());
  VectorXd state(3 + 2 * n);
  state.head<3>() = pose.vector();
  for (Index i = 0; i < n; ++i) state.segment<2>(3 + 2 * i) = places[std::size_t(i)];
  MatrixXd H(2 * n, state.size());
  constexpr double kStep = 1e-6;
  for (Index k = 0; k < state.size(); ++k) {
    VectorXd up = state, down = state;
    up(k) += kStep;
    down(k) -= kStep;
    VectorXd change = measurementOf(up, n) - measurementOf(down, n);
    for (Index i = 0; i < n; ++i) change(2 * i + 1) = wrapAngle(change(2 * i + 1));
    H.col(k) = change / (2.0 * kStep);
  }
  MatrixXd R = MatrixXd::Zero(2 * n, 2 * n);
  for (Index i = 0; i < n; ++i) {
    R(2 * i, 2 * i) = std::pow(sensor.range_deviation_m, 2);
    R(2 * i + 1, 2 * i + 1) = std::pow(sensor.bearing_deviation_rad, 2);
  }
  const MatrixXd K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
  const MatrixXd I_KH = MatrixXd::Identity(state.size(), state.size()) - K * H;
  return (I_KH * P * I_KH.transpose() + K * R * K.transpose()).topLeftCorner<3, 3>();
}

/// What it gains if it knows next to nothing of the pose before: (29) without its formulas.
Matrix3d gainOfFilter(const Pose2& pose, const std::vector<Vector2d>& places, const MatrixXd& P_L,
                      const ExpectedSensor& sensor) {
  constexpr double kDiffuse = 1e3;
  MatrixXd P = MatrixXd::Zero(3 + P_L.rows(), 3 + P_L.rows());
  P.topLeftCorner<3, 3>().diagonal().setConstant(kDiffuse);
  P.bottomRightCorner(P_L.rows(), P_L.rows()) = P_L;
  return posteriorOfFilter(pose, places, P, sensor).inverse() - Matrix3d::Identity() / kDiffuse;
}

RC_GTEST_PROP(InformationEvaluator, EqualsTheGainOfAFilterWithDiffusePrior, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto places = randomPlaces(*rc::gen::inRange(2, 12), 15.0, generator);
  const MatrixXd P = randomCovariance(places, generator);
  const InformationConfig config = roundLooking();
  InformationEvaluator evaluator(config);
  const Pose2 pose{0.3, -0.2, sampleUniform(generator, -3.0, 3.0)};
  const auto information = evaluator.at(LandmarkField(mapOf(places, P), kCell_m), pose);
  RC_ASSERT(information.landmarks == static_cast<int>(places.size()));
  const Matrix3d gain = gainOfFilter(pose, places, P, config.sensor);
  // Numeric derivatives and the diffuse prior leave about seven digits.
  RC_ASSERT((information.matrix - gain).norm() < 1e-6 * gain.norm());
}

RC_GTEST_PROP(InformationEvaluator, BoundsWhatAnyFilterKnowsAfterOneLook, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto places = randomPlaces(*rc::gen::inRange(2, 10), 15.0, generator);
  const MatrixXd P_L = randomCovariance(places, generator);
  // A vehicle in a SLAM map: its error has much in common with those of the landmarks.
  MatrixXd shared(3, P_L.rows());
  for (double& entry : shared.reshaped()) entry = sampleNormal(generator, 0.3);
  const double own = sampleUniform(generator, 1e-4, 10.0);
  MatrixXd P(3 + P_L.rows(), 3 + P_L.rows());
  P << shared * P_L * shared.transpose() + own * Matrix3d::Identity(), shared * P_L,
      P_L * shared.transpose(), P_L;
  const InformationConfig config = roundLooking();
  InformationEvaluator evaluator(config);
  const Pose2 pose{0.3, -0.2, sampleUniform(generator, -3.0, 3.0)};
  const Matrix3d promised = evaluator.at(LandmarkField(mapOf(places, P_L), kCell_m), pose).matrix;
  const Matrix3d P_v = posteriorOfFilter(pose, places, P, config.sensor);
  // P_v <= dY^-1 in the order of matrices; numeric derivatives leave about seven digits.
  const Matrix3d root = promised.llt().matrixL();
  const double excess = Eigen::SelfAdjointEigenSolver<Matrix3d>(root.transpose() * P_v * root)
                            .eigenvalues()
                            .maxCoeff();
  RC_ASSERT(excess <= 1.0 + 1e-5);
}

RC_GTEST_PROP(InformationEvaluator, MovesWithMapAndPose, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto places = randomPlaces(8, 30.0, generator);
  const MatrixXd P = randomCovariance(places, generator);
  const Pose2 motion{-40.0, 25.0, sampleUniform(generator, -3.0, 3.0)};
  std::vector<Vector2d> moved;
  MatrixXd turn = MatrixXd::Zero(P.rows(), P.cols());
  for (std::size_t i = 0; i < places.size(); ++i) {
    moved.push_back(motion * places[i]);
    turn.block<2, 2>(Index(2 * i), Index(2 * i)) = motion.rotation();
  }
  InformationConfig config = roundLooking();
  config.sensor.field_of_view_rad = 2.5;
  config.heading = *rc::gen::element<std::string>("omnidirectional", "worst", "best");
  InformationEvaluator evaluator(config);
  const auto here = evaluator.at(LandmarkField(mapOf(places, P), kCell_m), Vector2d(1.0, 2.0));
  const auto there = evaluator.at(LandmarkField(mapOf(moved, turn * P * turn.transpose()), kCell_m),
                                  motion * Vector2d(1.0, 2.0));
  // Of headings that all inform of nothing, which is chosen depends on the axes.
  RC_ASSERT(here.value == 0.0 || here.landmarks == there.landmarks);
  RC_ASSERT(std::abs(here.value - there.value) <= 1e-8 * (1.0 + here.value));
}

RC_GTEST_PROP(InformationEvaluator, IsALowerBoundWhereThereAreMoreLandmarksThanCount, ()) {
  constexpr int kMost = static_cast<int>(InformationEvaluator::kMostLandmarks);
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const int count = *rc::gen::inRange(kMost - 20, kMost + 60);
  const auto places = randomPlaces(count, 15.0, generator);
  const MatrixXd P = randomCovariance(places, generator);
  InformationConfig config = roundLooking();
  config.measure = *rc::gen::element<std::string>("determinant", "smallest_eigenvalue", "trace");
  InformationEvaluator evaluator(config);
  const auto counted = evaluator.at(LandmarkField(mapOf(places, P), kCell_m), Pose2{});
  const Matrix3d all = gainOfFilter(Pose2{}, places, P, config.sensor);
  const double of_all = evaluator.measure().of(all);
  RC_ASSERT(counted.landmarks == std::min(count, kMost));
  // Numeric derivatives and the diffuse prior leave about seven digits.
  const double rounding = 1e-6;
  if (count <= kMost) RC_ASSERT((counted.matrix - all).norm() < rounding * all.norm());
  RC_ASSERT(counted.value <= of_all * (1.0 + rounding));
  const double least =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(all - counted.matrix).eigenvalues().minCoeff();
  RC_ASSERT(least >= -rounding * all.norm());
}

RC_GTEST_PROP(InformationEvaluator, IsALowerBoundAtTheHeadingThatItChooses, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto places = randomPlaces(*rc::gen::inRange(120, 150), 15.0, generator);
  const MatrixXd P = randomCovariance(places, generator);
  InformationConfig config = roundLooking();
  config.sensor.field_of_view_rad = sampleUniform(generator, 2.5, 4.0);
  config.heading = *rc::gen::element<std::string>("worst", "best", "fixed");
  const auto counted =
      InformationEvaluator(config).at(LandmarkField(mapOf(places, P), kCell_m), Vector2d(0.0, 0.0));
  std::vector<Vector2d> in_view;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double bearing =
        wrapAngle(std::atan2(places[i].y(), places[i].x()) - counted.heading_rad);
    if (std::abs(bearing) > 0.5 * config.sensor.field_of_view_rad) continue;
    in_view.push_back(places[i]);
    rows.push_back(i);
  }
  MatrixXd P_view(2 * Index(rows.size()), 2 * Index(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      P_view.block<2, 2>(2 * Index(i), 2 * Index(j)) =
          P.block<2, 2>(2 * Index(rows[i]), 2 * Index(rows[j]));
    }
  }
  const Pose2 pose{0.0, 0.0, counted.heading_rad};
  const Matrix3d all = gainOfFilter(pose, in_view, P_view, config.sensor);
  RC_ASSERT(counted.landmarks >= 2);
  const double least =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(all - counted.matrix).eigenvalues().minCoeff();
  RC_ASSERT(least >= -1e-6 * all.norm());
}

RC_GTEST_PROP(InformationEvaluator, NeverLosesByAnotherLandmark, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  auto places = randomPlaces(9, 15.0, generator);
  const MatrixXd P = randomCovariance(places, generator);
  InformationEvaluator evaluator(roundLooking());
  const auto more = evaluator.at(LandmarkField(mapOf(places, P), kCell_m), Vector2d::Zero());
  places.pop_back();
  const auto less = evaluator.at(LandmarkField(mapOf(places, P.topLeftCorner(16, 16)), kCell_m),
                                 Vector2d::Zero());
  const Eigen::Vector3d gained =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(more.matrix - less.matrix).eigenvalues();
  RC_ASSERT(gained.minCoeff() >= -1e-10 * more.matrix.trace());
  RC_ASSERT(more.value >= less.value * (1.0 - 1e-12));
}

RC_GTEST_PROP(InformationEvaluator, StaysBelowTheTruthWherePairsAreNotTold, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto places = randomPlaces(8, 15.0, generator);
  const MatrixXd P = randomCovariance(places, generator);
  LandmarkMap map = mapOf(places, P);
  InformationEvaluator evaluator(roundLooking());
  const auto truth = evaluator.at(LandmarkField(map, kCell_m), Vector2d::Zero());
  auto& pairs = map.cross_covariances;
  for (int i = 0; i < 6; ++i) {
    pairs.erase(pairs.begin() + std::ptrdiff_t(generator() % pairs.size()));
  }
  const auto told = evaluator.at(LandmarkField(map, kCell_m), Vector2d::Zero());
  const Eigen::Vector3d lost =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(truth.matrix - told.matrix).eigenvalues();
  RC_ASSERT(lost.minCoeff() >= -1e-10 * truth.matrix.trace());
  RC_ASSERT(told.landmarks < 8);
  RC_ASSERT(evaluator.counts().left_out == std::size_t(8 - told.landmarks));
}

RC_GTEST_PROP(InformationEvaluator, FindsTheExtremeHeadings, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint32_t>());
  const auto places = randomPlaces(6, 15.0, generator);
  const LandmarkField field(mapOf(places, randomCovariance(places, generator)), kCell_m);
  InformationConfig config = roundLooking();
  config.sensor.field_of_view_rad = sampleUniform(generator, 0.5, 6.0);
  config.heading = "worst";
  const double worst = InformationEvaluator(config).at(field, Vector2d(0.0, 0.0)).value;
  config.heading = "best";
  InformationEvaluator evaluator(config);
  const double best = evaluator.at(field, Vector2d(0.0, 0.0)).value;
  double least = 1e9, most = 0.0;
  for (int i = 0; i < 720; ++i) {
    const double value = evaluator.at(field, Pose2{0.0, 0.0, wrapAngle(i * kPi / 360.0)}).value;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  // Half a degree may step over a heading that only the exact search finds.
  RC_ASSERT(worst <= least * (1.0 + 1e-9));
  RC_ASSERT(best >= most * (1.0 - 1e-9));
}

TEST(InformationEvaluator, SaysNothingWithoutLandmarks) {
  InformationEvaluator evaluator(roundLooking());
  const auto information = evaluator.at(LandmarkField(LandmarkMap{}, kCell_m), Vector2d::Zero());
  EXPECT_EQ(information.value, 0.0);
  EXPECT_EQ(information.landmarks, 0);
  EXPECT_TRUE(information.matrix.isZero());
}

TEST(InformationEvaluator, LeavesADirectionFreeWithOneLandmark) {
  const LandmarkField field(mapOf({{5.0, 3.0}}, 0.01 * Matrix2d::Identity()), kCell_m);
  for (const char* measure : {"determinant", "smallest_eigenvalue"}) {
    InformationConfig config = roundLooking();
    config.measure = measure;
    const auto information = InformationEvaluator(config).at(field, Vector2d::Zero());
    EXPECT_EQ(information.value, 0.0) << measure;
    EXPECT_EQ(information.landmarks, 1);
    EXPECT_GT(information.matrix.trace(), 0.0);
  }
}

TEST(InformationEvaluator, WelcomesASingularCovariance) {
  const std::vector<Vector2d> places = {{5.0, 3.0}, {-4.0, 6.0}, {2.0, -7.0}};
  MatrixXd common = MatrixXd::Zero(6, 6);  // all landmarks move together, along x only
  for (Index i = 0; i < 6; i += 2) {
    for (Index j = 0; j < 6; j += 2) common(i, j) = 0.04;
  }
  InformationEvaluator evaluator(roundLooking());
  const auto information =
      evaluator.at(LandmarkField(mapOf(places, common), kCell_m), Vector2d::Zero());
  // Nothing can tell x better than the landmarks' common error.
  const Matrix3d P = information.matrix.inverse();
  EXPECT_GT(P(0, 0), 0.04);
  EXPECT_LT(P(0, 0), 0.05);
  EXPECT_LT(P(1, 1), 0.01);
  EXPECT_EQ(evaluator.counts().unusable, 0U);
}

TEST(InformationEvaluator, ExactLandmarksLeaveTheSensorsNoise) {
  const std::vector<Vector2d> places = {{10.0, 0.0}, {0.0, 10.0}};
  const InformationConfig config = roundLooking();
  const auto information = InformationEvaluator(config).at(
      LandmarkField(mapOf(places, MatrixXd::Zero(4, 4)), kCell_m), Vector2d::Zero());
  const double range = 1.0 / std::pow(config.sensor.range_deviation_m, 2);
  const double across = 1.0 / std::pow(10.0 * config.sensor.bearing_deviation_rad, 2);
  Matrix3d expected;
  expected << range + across, 0.0, -10.0 * across,  //
      0.0, range + across, 10.0 * across,           //
      -10.0 * across, 10.0 * across, 200.0 * across;
  EXPECT_TRUE(information.matrix.isApprox(expected, 1e-12));
}

TEST(InformationEvaluator, CountsACovarianceThatCannotBe) {
  LandmarkMap map = mapOf({{5.0, 3.0}, {-4.0, 6.0}}, 0.01 * MatrixXd::Identity(4, 4));
  map.cross_covariances[0].block = 5.0 * Matrix2d::Identity();
  InformationEvaluator evaluator(roundLooking());
  const auto information = evaluator.at(LandmarkField(map, kCell_m), Vector2d::Zero());
  EXPECT_EQ(information.value, 0.0);
  EXPECT_EQ(evaluator.counts().unusable, 1U);
}

TEST(InformationEvaluator, DoesNotCountOnWhatIsHidden) {
  const std::vector<Vector2d> places = {{5.0, 3.0}, {-4.0, 6.0}, {2.0, -7.0}};
  const LandmarkField field(mapOf(places, 0.01 * MatrixXd::Identity(6, 6)), kCell_m);
  InformationEvaluator evaluator(
      roundLooking(), [](const Vector2d& /*from*/, const Vector2d& to) { return to.y() < 0.0; });
  EXPECT_EQ(evaluator.at(field, Vector2d(0.0, 0.0)).landmarks, 2);
}

TEST(InformationEvaluator, TellsHowFarTheVisibleSetIsFromChanging) {
  const double range_m = roundLooking().sensor.range_m;
  const std::vector<Vector2d> places = {{range_m - 0.5, 0.0}, {0.0, range_m + 0.3}, {0.0, 5.0}};
  const LandmarkField field(mapOf(places, MatrixXd::Zero(6, 6)), kCell_m);
  InformationEvaluator evaluator(roundLooking());
  const auto information = evaluator.at(field, Vector2d(0.0, 0.0));
  EXPECT_EQ(information.landmarks, 2);
  EXPECT_NEAR(information.margin_m, 0.3, 1e-12);
}

TEST(InformationEvaluator, RefusesUnknownWords) {
  InformationConfig config = roundLooking();
  config.measure = "volume";
  EXPECT_THROW(InformationEvaluator{config}, ConfigError);
  config = roundLooking();
  config.heading = "north";
  EXPECT_THROW(InformationEvaluator{config}, ConfigError);
}

TEST(InformationMeasure, AgreesWithItsDefinition) {
  const Matrix3d Y = Eigen::Vector3d(4.0, 25.0, 900.0).asDiagonal();
  EXPECT_NEAR(InformationMeasure("determinant", 10.0).of(Y), std::cbrt(900.0), 1e-12);
  EXPECT_NEAR(InformationMeasure("smallest_eigenvalue", 10.0).of(Y), 4.0, 1e-12);
  EXPECT_NEAR(InformationMeasure("trace", 10.0).of(Y), 38.0, 1e-12);
}

TEST(LandmarkField, RefusesWhatCannotBeUsed) {
  LandmarkMap map = mapOf({{5.0, 3.0}, {-4.0, 6.0}, {1.0, 1.0}}, 0.01 * MatrixXd::Identity(6, 6));
  map.landmarks[1].covariance(0, 0) = -1.0;
  map.landmarks[2].position.x() = std::nan("");
  const LandmarkField field(map, kCell_m);
  EXPECT_EQ(field.size(), 1);
  EXPECT_EQ(field.refusedLandmarks(), 2U);
  EXPECT_EQ(field.refusedPairs(), 3U);
}

TEST(LandmarkField, FindsLandmarksNearPlacesFarOutside) {
  const LandmarkField field(mapOf({{5.0, 3.0}, {-4.0, 6.0}}, MatrixXd::Zero(4, 4)), 1.0);
  int found = 0;
  field.visitNear({1e12, -1e12}, 15.0, [&](int /*index*/) { ++found; });
  EXPECT_EQ(found, 0);
  field.visitNear({5.0, 3.0}, 0.1, [&](int index) { found += 1 + index; });
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace hymm::core
