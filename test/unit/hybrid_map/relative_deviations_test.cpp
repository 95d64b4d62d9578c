#include "hybrid_map/relative_deviations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_set>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;

constexpr double kRange_m = 30.0;  // of the pairs that a map tells

/// What a vehicle knows that drove straight between two rows of landmarks, 10 m apart, and looked
/// around itself: all joint covariances, as a batch solution linearised at the truth gives them.
class Drive {
 public:
  explicit Drive(double look_m = 25.0) : landmarks_(2 * kPlaces) {
    constexpr double kStep_m = 2.0, kAlong_sd = 0.05, kAcross_sd = 0.05, kHeading_sd = 0.005;
    const auto poses = static_cast<Eigen::Index>(kLength_m / kStep_m);
    MatrixXd information = MatrixXd::Zero(3 * poses + 2 * landmarks_, 3 * poses + 2 * landmarks_);
    information.topLeftCorner<3, 3>() = Eigen::Vector3d(1.0, 1.0, 1.0 / (0.05 * 0.05)).asDiagonal();
    for (Eigen::Index p = 0; p < poses; ++p) {
      if (p > 0) {
        MatrixXd J(3, 6);  // of the way from the pose before, along x
        J << -1, 0, 0, 1, 0, 0, 0, -1, -kStep_m, 0, 1, 0, 0, 0, -1, 0, 0, 1;
        const Eigen::Vector3d sd(kAlong_sd, kAcross_sd, kHeading_sd);
        information.block<6, 6>(3 * p - 3, 3 * p - 3) +=
            J.transpose() * sd.cwiseProduct(sd).cwiseInverse().asDiagonal() * J;
      }
      for (Eigen::Index l = 0; l < landmarks_; ++l) {
        const Eigen::Vector2d offset = place(l) - Eigen::Vector2d(kStep_m * double(p), 0.0);
        if (offset.norm() > look_m) continue;
        look(3 * p, 3 * poses + 2 * l, offset, information);
      }
    }
    const MatrixXd all =
        information.llt().solve(MatrixXd::Identity(information.rows(), information.cols()));
    covariance_ = all.bottomRightCorner(2 * landmarks_, 2 * landmarks_);
  }

  Eigen::Vector2d place(Eigen::Index l) const {
    return {10.0 * static_cast<double>(l / 2), l % 2 == 0 ? -5.0 : 5.0};
  }
  Matrix2d block(Eigen::Index a, Eigen::Index b) const {
    return covariance_.block<2, 2>(2 * a, 2 * b);
  }
  double deviation(Eigen::Index a, Eigen::Index b) const {
    const Matrix2d relative = block(a, a) + block(b, b) - block(a, b) - block(b, a);
    return std::sqrt(relative.selfadjointView<Eigen::Lower>().eigenvalues()[1]);
  }
  double distance(Eigen::Index a, Eigen::Index b) const { return (place(a) - place(b)).norm(); }
  Eigen::Index size() const { return landmarks_; }
  std::unordered_set<int> ids() const {
    std::unordered_set<int> ids;
    for (int id = 0; id < static_cast<int>(landmarks_); ++id) ids.insert(id);
    return ids;
  }

  /// As the filter tells it.
  LandmarkMap map() const {
    LandmarkMap map;
    for (Eigen::Index a = 0; a < landmarks_; ++a) {
      LandmarkEstimate landmark;
      landmark.id = static_cast<int>(a);
      landmark.position = place(a);
      landmark.covariance = block(a, a);
      map.landmarks.push_back(landmark);
      for (Eigen::Index b = a + 1; b < landmarks_; ++b) {
        if (distance(a, b) > kRange_m) continue;
        map.cross_covariances.push_back({static_cast<int>(a), static_cast<int>(b), block(a, b)});
      }
    }
    return map;
  }

 private:
  static constexpr double kLength_m = 120.0;
  static constexpr Eigen::Index kPlaces = 12;

  /// A measured offset; the pose heads along x.
  static void look(Eigen::Index pose, Eigen::Index landmark, const Eigen::Vector2d& offset,
                   MatrixXd& information) {
    constexpr double kSd = 0.1;
    MatrixXd J(2, 5);  // by pose and landmark
    J << -1, 0, offset.y(), 1, 0, 0, -1, -offset.x(), 0, 1;
    const MatrixXd gained = J.transpose() * J / (kSd * kSd);
    information.block<3, 3>(pose, pose) += gained.topLeftCorner<3, 3>();
    information.block<2, 2>(landmark, landmark) += gained.bottomRightCorner<2, 2>();
    information.block<3, 2>(pose, landmark) += gained.topRightCorner<3, 2>();
    information.block<2, 3>(landmark, pose) += gained.bottomLeftCorner<2, 3>();
  }

  Eigen::Index landmarks_;
  MatrixXd covariance_;
};

TEST(RelativeDeviations, AreThoseOfTheJointCovarianceWhereTheMapTellsIt) {
  const Drive drive;
  const LandmarkMap map = drive.map();
  const RelativeDeviations deviations(map, drive.ids());
  EXPECT_NEAR(deviations.between(2, 5), drive.deviation(2, 5), 1e-9);
  EXPECT_EQ(deviations.between(3, 3), 0.0);
}

TEST(RelativeDeviations, ComeNearTheTruthThroughTheLandmarksBetween) {
  const Drive drive;
  const LandmarkMap map = drive.map();
  const RelativeDeviations deviations(map, drive.ids());
  int pairs = 0;
  for (Eigen::Index a = 0; a < drive.size(); ++a) {
    for (Eigen::Index b = a + 1; b < drive.size(); ++b) {
      if (drive.distance(a, b) <= kRange_m || drive.distance(a, b) > 51.0) continue;
      const double deviation = deviations.between(static_cast<int>(a), static_cast<int>(b));
      EXPECT_NEAR(deviation / drive.deviation(a, b), 1.0, 0.002) << a << " and " << b;
      ++pairs;
    }
  }
  EXPECT_GT(pairs, 50);
}

TEST(RelativeDeviations, AreAtMostTheSumWhereNothingIsBetween) {
  const Drive drive;
  const LandmarkMap map = drive.map();
  const RelativeDeviations deviations(map, drive.ids());
  const int last = static_cast<int>(drive.size()) - 1;  // 110 m on
  const auto deviationOf = [&](Eigen::Index l) {
    return std::sqrt(drive.block(l, l).selfadjointView<Eigen::Lower>().eigenvalues()[1]);
  };
  EXPECT_NEAR(deviations.between(0, last), deviationOf(0) + deviationOf(last), 1e-9);
  EXPECT_GT(deviations.between(0, last), drive.deviation(0, last));
}

TEST(RelativeDeviations, OfPairsAreNoMoreThanByWayOfTheOthers) {
  const Drive drive;
  const LandmarkMap map = drive.map();
  const RelativeDeviations deviations(map, drive.ids());
  // 0 and 14 are 70 m apart, too far for what lies between; 8 is near both.
  const double by_way = deviations.between(0, 8) + deviations.between(8, 14);
  ASSERT_LT(by_way, deviations.between(0, 14));
  EXPECT_NEAR(deviations.largest({0, 8}, {14, 14}), by_way, 1e-9);
  EXPECT_GT(deviations.largest({0, 8}, {14, 14}), drive.deviation(0, 14));
}

TEST(RelativeDeviations, OfUnknownLandmarksAreInfinite) {
  const Drive drive;
  const LandmarkMap map = drive.map();
  const RelativeDeviations deviations(map, drive.ids());
  EXPECT_TRUE(std::isinf(deviations.between(0, 99)));
  EXPECT_TRUE(std::isinf(deviations.largest({0, 1}, {2, 99})));
}

TEST(RelativeDeviations, AreTheSumWhereThoseBetweenTellNoDirection) {
  // 0 and 7 are 36 m apart. Of the landmarks between only two are told, 1 m apart.
  const Drive drive;
  LandmarkMap map = drive.map();
  map.landmarks[4].position = map.landmarks[2].position + Eigen::Vector2d(1.0, 0.0);
  const std::set<int> told = {0, 2, 4, 7};
  auto& pairs = map.cross_covariances;
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                             [&](const CrossCovariance& pair) {
                               return told.count(pair.first_id) + told.count(pair.second_id) < 2;
                             }),
              pairs.end());
  const RelativeDeviations clump(map, {0, 7});
  const double alone = clump.between(0, 7);
  map.landmarks[4].position = drive.place(4);
  const RelativeDeviations spread(map, {0, 7});
  EXPECT_LT(spread.between(0, 7), 0.8 * alone);
}

TEST(RelativeDeviations, AreNotMadeSmallByCovariancesThatCannotBe) {
  const Drive drive;
  LandmarkMap map = drive.map();
  for (CrossCovariance& pair : map.cross_covariances) {
    pair.block.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  map.cross_covariances.push_back({0, 999, Matrix2d::Zero()});
  map.cross_covariances.push_back({7, 999, Matrix2d::Zero()});
  const RelativeDeviations deviations(map, {0, 7});
  EXPECT_GE(deviations.between(0, 7), drive.deviation(0, 7));
}

}  // namespace
}  // namespace hymm::core
