#include "cekf/lasting_errors.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "cekf/landmark_registry.h"
#include "cekf/observation_model.h"
#include "common/chi_square.h"
#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr LastingErrorConfig kCamera{0.9, 0.5, 0.15};

Matrix2d anyCovariance() {
  Matrix2d covariance;
  covariance << 0.03, 0.001, 0.001, 4e-4;
  return covariance;
}

TEST(LastingErrorModel, PartsAnObservationsCovariance) {
  const LastingErrorModel model(kCamera);
  const Matrix2d L = model.factor(anyCovariance()), lasting = L * L.transpose();
  const Matrix2d fresh = model.fresh(anyCovariance());
  EXPECT_LT((lasting + fresh - anyCovariance()).norm(), 1e-15);
  EXPECT_NEAR(lasting(0, 0), 0.9 * 0.03, 1e-15);
  EXPECT_NEAR(lasting(1, 1), 0.5 * 4e-4, 1e-15);
  EXPECT_EQ(fresh.llt().info(), Eigen::Success);
}

TEST(LastingErrorModel, ForgetsAsTheViewChanges) {
  const LastingErrorModel model(kCamera);
  const Vector2d landmark(1.0, 1.0), before = landmark + Vector2d(4.0, 3.0);
  EXPECT_EQ(model.kept(before, before, landmark), 1.0);
  EXPECT_EQ(model.kept(landmark, landmark, landmark), 1.0);
  const Vector2d aside = before + 0.15 * Vector2d(-3.0, 4.0);  // by 0.15 of the range
  EXPECT_NEAR(model.kept(before, aside, landmark), std::exp(-1.0), 1e-12);
  EXPECT_EQ(model.kept(before, aside, landmark), model.kept(aside, before, landmark));
  EXPECT_EQ(model.kept(before, landmark, landmark), 0.0);
}

TEST(LastingErrors, AreHeldOnlyOfLandmarksInView) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3));
  LandmarkRegistry registry;
  LastingErrors errors;
  RegisteredLandmark landmark;
  landmark.id = 7;
  landmark.position = {5.0, 0.0};
  landmark.slot = filter.append(landmark.position, MatrixXd::Zero(2, 3), Matrix2d::Identity());
  landmark.lasting_error = errors.add(7, Vector2d::Zero(), filter);
  registry.add(landmark);
  const LastingErrorModel model(kCamera);
  errors.removeForgotten({0.5, 0.0}, model, registry, filter);
  ASSERT_TRUE(registry.byId(7).lasting_error.exists());
  const int slot = registry.byId(7).lasting_error.slot;
  errors.removeForgotten({4.0, 0.0}, model, registry, filter);
  EXPECT_FALSE(registry.byId(7).lasting_error.exists());
  EXPECT_FALSE(filter.holds(slot));
}

/// A robot whose wheels do not err passes two signs, and reads them in each of `steps` scans.
class Passage {
 public:
  explicit Passage(const LastingErrorConfig& claimed) {
    CekfSlamConfig config;
    config.lasting_errors = claimed;
    config.motion_input = "odom";
    VehicleConfig vehicle;
    vehicle.noise.speed_deviation_mps = 1e-4;
    vehicle.noise.speed_deviation_relative = 0.0;
    vehicle.noise.lateral_deviation_relative = 0.0;
    vehicle.noise.yaw_rate_deviation_radps = 1e-5;
    vehicle.noise.yaw_rate_deviation_relative = 0.0;
    slam_ = std::make_unique<CekfSlam>(config, vehicle);
  }

  /// The signs' errors are those of kCamera.
  void drive(double speed_mps, int steps, RandomGenerator& generator) {
    const LastingErrorModel model(kCamera);
    std::vector<Vector2d> errors(kSigns.size());
    for (Vector2d& error : errors) error = anyNormal(generator);
    Vector2d before = Vector2d::Zero();
    for (int step = 0; step < steps; ++step) {
      const double time_s = 0.1 * step;
      const Pose2 T_map_base{speed_mps * time_s, 0.0, 0.0};
      ObservationSet set;
      set.time_s = time_s;
      for (std::size_t k = 0; k < kSigns.size(); ++k) {
        const double kept = model.kept(before, T_map_base.position(), kSigns[k]);
        errors[k] = kept * errors[k] + std::sqrt(1.0 - kept * kept) * anyNormal(generator);
        set.observations.push_back(observe(static_cast<int>(k), T_map_base, errors[k], generator));
      }
      slam_->process(MotionInput{TwistInput{time_s, speed_mps, 0.0, 0.0}});
      slam_->process(set);
      before = T_map_base.position();
    }
  }

  LandmarkEstimate sign(std::size_t k) { return slam_->landmarkMap(0.0).landmarks.at(k); }
  double nees(std::size_t k) {
    const Vector2d error = sign(k).position - kSigns[k];
    return error.dot(sign(k).covariance.inverse() * error);
  }

 private:
  static Vector2d anyNormal(RandomGenerator& generator) {
    return {sampleNormal(generator, 1.0), sampleNormal(generator, 1.0)};
  }

  static Observation observe(int k, const Pose2& T_map_base, const Vector2d& error,
                             RandomGenerator& generator) {
    const LastingErrorModel model(kCamera);
    const Matrix2d R = Vector2d(0.03, 4e-4).asDiagonal();
    const Matrix2d fresh = model.fresh(R).llt().matrixL();
    const Vector2d z =
        predictRangeBearing(T_map_base, Pose2{}, kSigns[static_cast<std::size_t>(k)]).value +
        model.factor(R) * error + fresh * anyNormal(generator);
    Observation observation;
    observation.range_m = z[0];
    observation.bearing_rad = z[1];
    observation.covariance = R;
    observation.identity = k;
    return observation;
  }

  static const std::vector<Vector2d> kSigns;
  std::unique_ptr<CekfSlam> slam_;
};

const std::vector<Vector2d> Passage::kSigns = {{3.0, 2.0}, {4.0, -3.0}};

TEST(CekfSlam, DoesNotAverageALastingErrorAway) {
  RandomGenerator generator(1);
  Passage standing(kCamera);
  standing.drive(0.0, 300, generator);
  // Of the range, what lasts; the rest is averaged away.
  const Vector2d line = Vector2d(3.0, 2.0).normalized();
  const double variance = line.dot(standing.sign(0).covariance * line);
  EXPECT_NEAR(variance, 0.9 * 0.03, 0.05 * 0.03);
  Passage naive((LastingErrorConfig()));
  naive.drive(0.0, 300, generator);
  EXPECT_LT(line.dot(naive.sign(0).covariance * line), 0.01 * 0.03);
}

TEST(CekfSlam, LearnsFromOtherViews) {
  RandomGenerator generator(2);
  Passage passage(kCamera);
  passage.drive(0.2, 300, generator);
  EXPECT_LT(passage.sign(0).covariance.trace(), 0.3 * 0.03);
}

TEST(CekfSlam, IsConsistentWithLastingErrors) {
  // 100 drives, two signs of two coordinates each.
  double honest = 0.0, naive = 0.0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    RandomGenerator generator(seed), same(seed);
    Passage passage(kCamera), naive_passage((LastingErrorConfig()));
    passage.drive(0.2, 150, generator);
    naive_passage.drive(0.2, 150, same);
    for (const std::size_t k : {0U, 1U}) {
      honest += passage.nees(k);
      naive += naive_passage.nees(k);
    }
  }
  EXPECT_GT(honest, chiSquareQuantile(0.005, 400));
  EXPECT_LT(honest, chiSquareQuantile(0.995, 400));
  EXPECT_GT(naive, 2.0 * 400.0);
}

}  // namespace
}  // namespace hymm::core
