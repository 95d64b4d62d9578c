#include "cekf/compressed_ekf.h"

#include <chrono>
#include <cmath>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/effect_reader.h"
#include "common/random.h"
#include "support/filter_pair.h"
#include "support/worker_hold.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kVehicleStates = 6;
constexpr double kExact = 1e-9;

MatrixXd randomMatrix(RandomGenerator& generator, int rows, int columns, double deviation) {
  MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix(i) = sampleNormal(generator, deviation);
  return matrix;
}

/// Random landmarks, motion and observations for the compressed filter and the textbook one.
class RandomPair {
 public:
  RandomPair(unsigned seed, SerialWorker::Mode mode, int landmarks)
      : generator_(seed),
        pair_(VectorXd::Zero(kVehicleStates),
              VectorXd::LinSpaced(kVehicleStates, 0.1, 0.6).asDiagonal(), mode) {
    for (int i = 0; i < landmarks; ++i) {
      pair_.append(randomMatrix(generator_, 2, 1, 10.0),
                   randomMatrix(generator_, 2, kVehicleStates, 1.0), 0.1 * Matrix2d::Identity());
    }
  }

  test::FilterPair& pair() { return pair_; }
  CompressedEkf& filter() { return pair_.compressed(); }

  void step() {
    const MatrixXd J = MatrixXd::Identity(kVehicleStates, kVehicleStates) +
                       randomMatrix(generator_, kVehicleStates, kVehicleStates, 0.03);
    const MatrixXd root = randomMatrix(generator_, kVehicleStates, 2, 0.05);
    const VectorXd vehicle = J * pair_.full().state().head(kVehicleStates);
    filter().predict(vehicle, J, root * root.transpose());
    pair_.full().predict(vehicle, J, root * root.transpose());
    std::vector<test::FilterPair::Row> rows;
    const int last = static_cast<int>(pair_.slots().size()) - 1;
    for (int k = 0; k < 3; ++k) {
      const int id = std::uniform_int_distribution<int>(0, last)(generator_);
      rows.push_back({randomMatrix(generator_, 2, 1, 0.3),
                      randomMatrix(generator_, 2, kVehicleStates, 1.0),
                      {{id, randomMatrix(generator_, 2, 2, 1.0)}},
                      0.2 * Matrix2d::Identity()});
    }
    pair_.update(rows);
  }

 private:
  RandomGenerator generator_;
  test::FilterPair pair_;
};

TEST(CompressedEkf, StartsNoGlobalUpdateWhileOneIsPending) {
  RandomPair random(5, SerialWorker::Mode::kBackground, 20);
  random.step();
  {
    const test::WorkerHold hold(random.filter());
    EXPECT_TRUE(random.filter().globalUpdate());
    EXPECT_EQ(random.filter().activeCount(), 0U);
    random.step();
    EXPECT_TRUE(random.filter().isGlobalUpdatePending());
    EXPECT_FALSE(random.filter().globalUpdate());
    EXPECT_GT(random.filter().activeCount(), 0U);
  }
  random.filter().finishGlobalUpdate();
  EXPECT_FALSE(random.filter().isGlobalUpdatePending());
  EXPECT_TRUE(random.filter().globalUpdate());
  EXPECT_LT(random.pair().difference().covariance, kExact);
}

TEST(CompressedEkf, EqualsFullEkfWithLandmarksThatDependOnOtherStates) {
  RandomGenerator generator(4);
  RandomPair random(4, SerialWorker::Mode::kInline, 5);
  const int diameters = random.pair().appendQuantities({0.5, 0.3}, 0.04 * Matrix2d::Identity());
  const std::size_t landmarks = random.filter().landmarkCount();
  for (int i = 0; i < 12; ++i) {
    random.step();
    random.pair().append(randomMatrix(generator, 2, 1, 10.0),
                         randomMatrix(generator, 2, kVehicleStates, 1.0),
                         0.1 * Matrix2d::Identity(), diameters, randomMatrix(generator, 2, 2, 1.0));
    if (i % 4 == 3) random.filter().globalUpdate();
    ASSERT_LT(random.pair().difference().covariance, kExact);
    ASSERT_LT(random.pair().difference().state, kExact);
  }
  EXPECT_EQ(landmarks, 5U);
  EXPECT_EQ(random.filter().landmarkCount(), landmarks + 12);
}

TEST(CompressedEkf, TellsNoMoveOfQuantitiesThatAreNoPlace) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3));
  SparseMeasurement m;
  m.innovation << 0.5, -1.0;
  m.H_vehicle.resize(2, 0);
  m.landmarks[0] = filter.appendQuantities({1.0, 2.0}, Matrix2d::Identity());
  m.H_landmarks[0] = Matrix2d::Identity();
  EXPECT_EQ(filter.update({m}).largest_landmark_move_m, 0.0);
  EXPECT_NE(filter.landmark(m.landmarks[0]), Vector2d(1.0, 2.0));
}

TEST(CompressedEkf, ReadsTheSameBeforeAndAfterEachTileIsReplaced) {
  RandomPair random(8, SerialWorker::Mode::kBackground, 220);  // 456 states in 10 tiles
  CompressedEkf& filter = random.filter();
  std::vector<int> slots;
  for (int slot = 0; slot < 220; slot += 22) slots.push_back(slot);
  // How many readings fall into an update is for the scheduler to say: go on until some did.
  constexpr int kMostRounds = 200;
  int reads_while_pending = 0;
  for (int i = 0; i < 3 || (reads_while_pending < 3 && i < kMostRounds); ++i) {
    random.step();
    filter.finishGlobalUpdate();
    ASSERT_TRUE(filter.globalUpdate());
    std::vector<MatrixXd> readings;
    do {
      readings.push_back(filter.jointCovariance(slots));
      std::this_thread::sleep_for(std::chrono::microseconds(100));  // lets the worker have the lock
    } while (filter.isGlobalUpdatePending());
    const MatrixXd settled = filter.jointCovariance(slots);
    const VectorXd sigma = settled.diagonal().cwiseSqrt();
    for (const MatrixXd& reading : readings) {
      const MatrixXd error = (reading - settled).cwiseQuotient(sigma * sigma.transpose());
      ASSERT_LT(error.cwiseAbs().maxCoeff(), kExact);
    }
    reads_while_pending += static_cast<int>(readings.size()) - 1;
  }
  EXPECT_GT(reads_while_pending, 0);
}

/// Of the landmarks in `slots`: positions, one above the other, and their joint covariance.
std::pair<VectorXd, MatrixXd> readAll(const EffectReader& reader, const std::vector<int>& slots) {
  const auto n = static_cast<Eigen::Index>(2 * slots.size());
  std::pair<VectorXd, MatrixXd> read{VectorXd(n), MatrixXd(n, n)};
  for (Eigen::Index a = 0; a < n; a += 2) {
    const int index = CompressedEkf::storeIndex(slots[static_cast<std::size_t>(a / 2)]);
    read.first.segment<2>(a) = reader.state(index);
    for (Eigen::Index b = 0; b < n; b += 2) {
      const int other = CompressedEkf::storeIndex(slots[static_cast<std::size_t>(b / 2)]);
      read.second.block<2, 2>(a, b) = reader.covariance(index, other);
    }
  }
  return read;
}

TEST(CompressedEkf, ReadsLaterWhatWasKnownWhenAsked) {
  for (const auto mode : {SerialWorker::Mode::kInline, SerialWorker::Mode::kBackground}) {
    RandomPair random(9, mode, 12);
    std::vector<int> slots;
    for (const auto& [id, slot] : random.pair().slots()) slots.push_back(slot);
    for (int i = 0; i < 30; ++i) {
      random.step();
      if (i % 3 == 0) random.filter().globalUpdate();
      if (i % 3 == 1) random.step();
      const VectorXd state = random.pair().full().state().tail(24);
      const MatrixXd covariance = random.pair().full().covariance().bottomRightCorner(24, 24);
      std::pair<VectorXd, MatrixXd> read;
      random.filter().readLater(slots, [&](const EffectReader& r) { read = readAll(r, slots); });
      random.step();  // what comes later does not matter
      random.filter().finishGlobalUpdate();
      const VectorXd sigma = covariance.diagonal().cwiseSqrt();
      ASSERT_LT((read.first - state).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), kExact);
      const MatrixXd error = (read.second - covariance).cwiseQuotient(sigma * sigma.transpose());
      ASSERT_LT(error.cwiseAbs().maxCoeff(), kExact);
    }
  }
}

TEST(CompressedEkf, TellsStatesAfterAnUpdateWithoutMakingIt) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3));
  const int slot = filter.append({1.0, 2.0}, MatrixXd::Identity(2, 3), Matrix2d::Identity());
  SparseMeasurement m;
  m.innovation << 0.5, -1.0;
  m.H_vehicle = MatrixXd::Zero(2, 3);
  m.landmarks[0] = slot;
  m.H_landmarks[0] = Matrix2d::Identity();
  const VectorXd after = filter.statesAfter({m}).value();
  EXPECT_EQ(filter.landmark(slot), Vector2d(1.0, 2.0));
  const UpdateOutcome outcome = filter.update({m});
  EXPECT_LT((after.head<3>() - filter.vehicle()).norm(), 1e-14);
  EXPECT_LT((filter.landmarkAmong(after, slot) - filter.landmark(slot)).norm(), 1e-14);
  // Prior variance 2, noise 1: two thirds of the innovation, which is 1.118 m long.
  EXPECT_NEAR(outcome.largest_landmark_move_m, 2.0 / 3.0 * m.innovation.norm(), 1e-12);
}

TEST(CompressedEkf, JointCovarianceIsSymmetricAndPositive) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3));
  std::vector<int> slots;
  for (int i = 0; i < 4; ++i) {
    Eigen::Matrix<double, 2, Eigen::Dynamic> G = MatrixXd::Identity(2, 3);
    slots.push_back(filter.append({1.0 * i, 2.0}, G, 0.01 * Matrix2d::Identity()));
  }
  filter.globalUpdate();
  filter.activate(slots[2]);
  const MatrixXd joint = filter.jointCovariance(slots);
  EXPECT_EQ((joint - joint.transpose()).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_NEAR(joint(0, 2), 1.0, 1e-12);
  EXPECT_NEAR(joint(0, 0), 1.01, 1e-12);
}

TEST(CompressedEkf, RefusesAnInnovationCovarianceThatIsNotPositive) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3));
  SparseMeasurement m;
  m.H_vehicle = MatrixXd::Identity(2, 3);
  m.noise = -5.0 * Matrix2d::Identity();
  EXPECT_TRUE(std::isnan(filter.update({m}).nis));
  EXPECT_EQ(filter.vehicleCovariance(), MatrixXd::Identity(3, 3));
}

TEST(CompressedEkf, RefusesSizesThatDoNotFit) {
  EXPECT_THROW(CompressedEkf(VectorXd::Zero(3), MatrixXd::Identity(2, 2)), std::invalid_argument);
  EXPECT_THROW(CompressedEkf(VectorXd::Zero(0), MatrixXd(0, 0)), std::invalid_argument);
  EXPECT_THROW(CompressedEkf(VectorXd::Zero(17), MatrixXd::Identity(17, 17)),
               std::invalid_argument);
}

}  // namespace
}  // namespace hymm::core
