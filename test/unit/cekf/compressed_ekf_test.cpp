#include "cekf/compressed_ekf.h"

#include <chrono>
#include <cmath>
#include <future>
#include <map>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/effect_reader.h"
#include "common/random.h"
#include "support/full_ekf.h"

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
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) matrix(i, j) = sampleNormal(generator, deviation);
  }
  return matrix;
}

struct TwoFiltersState {
  VectorXd state;
  MatrixXd covariance;
};

/// Drives the compressed filter and the full EKF through the same random history.
class TwoFilters {
 public:
  explicit TwoFilters(unsigned seed, SerialWorker::Mode mode = SerialWorker::Mode::kInline)
      : generator_(seed),
        compressed_(VectorXd::Zero(kVehicleStates), initialCovariance(), mode),
        full_(VectorXd::Zero(kVehicleStates), initialCovariance()) {}

  void step() {
    predict();
    const double dice = sampleUniform(generator_, 0.0, 1.0);
    if (dice < 0.15 || slots_.size() < 3) append();
    if (dice > 0.94 && slots_.size() > 8) remove();
    if (dice > 0.5 && dice < 0.53) fuse();
    if (dice > 0.6 && dice < 0.63) absoluteFix();
    if (dice > 0.7 && dice < 0.705) initialise();
    observe();
    if (dice > 0.3 && dice < 0.36 && compressed_.globalUpdate()) {
      EXPECT_EQ(compressed_.activeCount(), 0U);
      expectEqual();
    }
  }

  /// States in units of their deviation, covariances in units of theirs.
  void expectEqual() {
    const VectorXd sigma = full_.covariance().diagonal().cwiseSqrt();
    const auto nv = static_cast<Eigen::Index>(kVehicleStates);
    for (Eigen::Index i = 0; i < nv; ++i) {
      ASSERT_LT(std::abs(compressed_.vehicle()[i] - full_.state()[i]), kExact * sigma[i]);
    }
    expectBlock(compressed_.vehicleCovariance(), 0, 0, sigma);
    for (const auto& [id, slot] : slots_) {
      const Eigen::Index a = full_.index(id);
      const Vector2d error = compressed_.landmark(slot) - full_.state().segment<2>(a);
      ASSERT_LT(error.cwiseQuotient(sigma.segment<2>(a)).cwiseAbs().maxCoeff(), kExact);
      expectBlock(compressed_.vehicleLandmarkCovariance(slot), 0, a, sigma);
      for (const auto& [other_id, other_slot] : slots_) {
        expectBlock(compressed_.covariance(slot, other_slot), a, full_.index(other_id), sigma);
      }
    }
  }

  CompressedEkf& compressed() { return compressed_; }
  void append(int count) {
    for (int i = 0; i < count; ++i) append();
  }

  void observe() {
    std::vector<SparseMeasurement> measurements;
    std::vector<test::FullEkf::Row> rows;
    std::map<int, int> seen;
    for (int k = 0; k < 3; ++k) seen.insert(*pick());
    for (const auto& [id, slot] : seen) {
      compressed_.activate(slot);
      SparseMeasurement m;
      m.innovation = randomMatrix(generator_, 2, 1, 0.3);
      m.H_vehicle = randomMatrix(generator_, 2, kVehicleStates, 1.0);
      m.landmarks[0] = slot;
      m.H_landmarks[0] = randomMatrix(generator_, 2, 2, 1.0);
      m.noise = 0.2 * Matrix2d::Identity();
      rows.push_back({m.innovation, m.H_vehicle, {{id, m.H_landmarks[0]}}, m.noise});
      measurements.push_back(m);
    }
    EXPECT_GT(compressed_.update(measurements).nis, 0.0);
    full_.update(rows);
  }

  /// What a job of the worker reads of all landmarks as they are now.
  void expectLaterReadingEqual() {
    std::vector<int> slots;
    for (const auto& [id, slot] : slots_) slots.push_back(slot);
    std::map<int, Vector2d> positions;
    std::map<std::pair<int, int>, Matrix2d> blocks;
    compressed_.readLater(slots, [&](const EffectReader& reader) {
      for (const int a : slots) {
        positions[a] = reader.state(CompressedEkf::storeIndex(a));
        for (const int b : slots) {
          blocks[{a, b}] =
              reader.covariance(CompressedEkf::storeIndex(a), CompressedEkf::storeIndex(b));
        }
      }
    });
    const auto expected = slots_;
    const TwoFiltersState now{full_.state(), full_.covariance()};
    observe();  // what comes later does not matter to the job
    compressed_.finishGlobalUpdate();
    const VectorXd sigma = now.covariance.diagonal().cwiseSqrt();
    for (const auto& [id, slot] : expected) {
      const Eigen::Index a = full_.index(id);
      const Vector2d error = positions[slot] - now.state.segment<2>(a);
      ASSERT_LT(error.cwiseQuotient(sigma.segment<2>(a)).cwiseAbs().maxCoeff(), kExact);
      for (const auto& [other_id, other_slot] : expected) {
        const Eigen::Index b = full_.index(other_id);
        const Matrix2d difference = blocks[{slot, other_slot}] - now.covariance.block<2, 2>(a, b);
        for (int i = 0; i < 2; ++i) {
          for (int j = 0; j < 2; ++j) {
            ASSERT_LT(std::abs(difference(i, j)), kExact * sigma[a + i] * sigma[b + j]);
          }
        }
      }
    }
  }
  std::size_t landmarks() const { return slots_.size(); }

 private:
  static MatrixXd initialCovariance() {
    return VectorXd::LinSpaced(kVehicleStates, 0.1, 0.6).asDiagonal();
  }

  void expectBlock(const MatrixXd& block, Eigen::Index row, Eigen::Index column,
                   const VectorXd& sigma) {
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      for (Eigen::Index j = 0; j < block.cols(); ++j) {
        const double error = std::abs(block(i, j) - full_.covariance()(row + i, column + j));
        ASSERT_LT(error, kExact * sigma[row + i] * sigma[column + j]);
      }
    }
  }

  void predict() {
    const MatrixXd J = MatrixXd::Identity(kVehicleStates, kVehicleStates) +
                       randomMatrix(generator_, kVehicleStates, kVehicleStates, 0.03);
    const MatrixXd root = randomMatrix(generator_, kVehicleStates, 2, 0.05);
    const MatrixXd Q = root * root.transpose();
    const VectorXd vehicle = J * full_.state().head(kVehicleStates);
    compressed_.predict(vehicle, J, Q);
    full_.predict(vehicle, J, Q);
  }

  void append() {
    const MatrixXd G = randomMatrix(generator_, 2, kVehicleStates, 1.0);
    const Vector2d position = randomMatrix(generator_, 2, 1, 10.0);
    const Matrix2d noise = 0.1 * Matrix2d::Identity();
    slots_[next_id_] = compressed_.append(position, G, noise);
    full_.append(next_id_++, position, G, noise);
  }

  void remove() {
    const auto victim = pick();
    compressed_.remove(victim->second);
    full_.remove(victim->first);
    slots_.erase(victim);
  }

  void fuse() {
    const auto a = pick(), b = pick();
    if (a == b) return;
    compressed_.activate(a->second);
    compressed_.activate(b->second);
    SparseMeasurement m;
    m.innovation = randomMatrix(generator_, 2, 1, 0.1);
    m.landmarks[0] = a->second;
    m.landmarks[1] = b->second;
    m.H_landmarks[0] = Matrix2d::Identity();
    m.H_landmarks[1] = -Matrix2d::Identity();
    m.noise = 1e-2 * Matrix2d::Identity();
    compressed_.update({m});
    full_.update({{m.innovation,
                   MatrixXd(2, 0),
                   {{a->first, m.H_landmarks[0]}, {b->first, m.H_landmarks[1]}},
                   m.noise}});
  }

  void absoluteFix() {
    SparseMeasurement m;
    m.innovation = randomMatrix(generator_, 2, 1, 0.5);
    m.H_vehicle = randomMatrix(generator_, 2, kVehicleStates, 1.0);
    m.noise = 0.5 * Matrix2d::Identity();
    compressed_.update({m});
    full_.update({{m.innovation, m.H_vehicle, {}, m.noise}});
  }

  void initialise() {
    const MatrixXd G = randomMatrix(generator_, 2, kVehicleStates, 1.0);
    const Vector2d value = randomMatrix(generator_, 2, 1, 1.0);
    compressed_.initialiseVehicleStates(4, value, G, 0.3 * Matrix2d::Identity());
    full_.initialiseVehicleStates(4, value, G, 0.3 * Matrix2d::Identity());
  }

  std::map<int, int>::iterator pick() {
    const auto index = std::uniform_int_distribution<std::size_t>(0, slots_.size() - 1)(generator_);
    return std::next(slots_.begin(), static_cast<std::ptrdiff_t>(index));
  }

  RandomGenerator generator_;
  CompressedEkf compressed_;
  test::FullEkf full_;
  std::map<int, int> slots_;  // id to slot
  int next_id_ = 0;
};

TEST(CompressedEkf, EqualsFullEkfAfterGlobalUpdates) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    TwoFilters filters(seed);
    for (int i = 0; i < 250 && !testing::Test::HasFailure(); ++i) filters.step();
    EXPECT_GT(filters.landmarks(), 10U);
  }
}

TEST(CompressedEkf, EqualsFullEkfBetweenGlobalUpdatesForActiveAndPassiveLandmarks) {
  TwoFilters filters(4);
  for (int i = 0; i < 150 && !testing::Test::HasFailure(); ++i) {
    filters.step();
    filters.expectEqual();
  }
}

TEST(CompressedEkf, EqualsFullEkfWhileTheGlobalUpdateIsPending) {
  for (const unsigned seed : {5U, 6U, 7U}) {
    TwoFilters filters(seed, SerialWorker::Mode::kBackground);
    CompressedEkf& filter = filters.compressed();
    filters.append(20);
    for (int i = 0; i < 40; ++i) filters.step();
    filter.finishGlobalUpdate();
    std::promise<void> gate;
    filter.readLater({}, [open = gate.get_future().share()](const EffectReader&) { open.wait(); });
    ASSERT_TRUE(filter.globalUpdate());
    for (int i = 0; i < 40 && !testing::Test::HasFailure(); ++i) {
      filters.step();
      filters.expectEqual();
      ASSERT_TRUE(filter.isGlobalUpdatePending());
      EXPECT_FALSE(filter.globalUpdate());
    }
    gate.set_value();
    filter.finishGlobalUpdate();
    EXPECT_FALSE(filter.isGlobalUpdatePending());
    filters.expectEqual();
    EXPECT_TRUE(filter.globalUpdate());
    filters.expectEqual();
    filter.finishGlobalUpdate();
    filters.expectEqual();
  }
}

TEST(CompressedEkf, ReadsTheSameBeforeAndAfterEachTileIsReplaced) {
  TwoFilters filters(8, SerialWorker::Mode::kBackground);
  CompressedEkf& filter = filters.compressed();
  filters.append(220);  // 456 states in 10 tiles
  std::vector<int> slots;
  for (int slot = 0; slot < 220; slot += 22) slots.push_back(slot);
  // How many readings fall into an update is for the scheduler to say: go on until some did.
  int reads_while_pending = 0;
  constexpr int kMostRounds = 200;
  for (int i = 0; i < 3 || (reads_while_pending < 3 && i < kMostRounds); ++i) {
    filters.observe();
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

TEST(CompressedEkf, ReadsLaterWhatWasKnownWhenAsked) {
  for (const auto mode : {SerialWorker::Mode::kInline, SerialWorker::Mode::kBackground}) {
    TwoFilters filters(9, mode);
    for (int i = 0; i < 100 && !testing::Test::HasFailure(); ++i) {
      filters.step();
      if (i % 10 == 9) filters.expectLaterReadingEqual();
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
