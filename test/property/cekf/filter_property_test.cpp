// Random histories of the compressed filter, beside the textbook one.

#include <memory>
#include <ostream>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"
#include "support/filter_pair.h"
#include "support/shadowed_drive.h"
#include "support/worker_hold.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kVehicleStates = 6;
constexpr double kExact = 1e-9;

enum class Kind {
  kPredict,
  kAppend,
  kRemove,
  kObserve,
  kFuse,
  kFix,
  kInitialise,
  kAddVehicleError,
  kRedefineErrors,
  kFade,
  kSlip,
  kGlobalUpdate,
  kFinishGlobalUpdate
};

/// Something that happens to a filter. `chance` decides its numbers, so that a history shrinks step
/// by step.
struct Step {
  Kind kind;
  unsigned chance;
};

void showValue(const Step& step, std::ostream& stream) {
  static const char* const kNames[] = {"predict", "append", "remove",        "observe",
                                       "fuse",    "fix",    "initialise",    "vehicle error",
                                       "fade",    "slip",   "global update", "finish"};
  stream << kNames[static_cast<int>(step.kind)] << ' ' << step.chance;
}

rc::Gen<std::vector<Step>> anyHistory() {
  const auto kind = rc::gen::weightedElement<Kind>({{8, Kind::kPredict},
                                                    {5, Kind::kAppend},
                                                    {2, Kind::kRemove},
                                                    {10, Kind::kObserve},
                                                    {1, Kind::kFuse},
                                                    {1, Kind::kFix},
                                                    {1, Kind::kInitialise},
                                                    {2, Kind::kAddVehicleError},
                                                    {2, Kind::kRedefineErrors},
                                                    {2, Kind::kFade},
                                                    {1, Kind::kSlip},
                                                    {2, Kind::kGlobalUpdate},
                                                    {1, Kind::kFinishGlobalUpdate}});
  // Twice as long as RapidCheck would make them: short histories find little.
  return rc::gen::scale(2.0, rc::gen::container<std::vector<Step>>(
                                 rc::gen::construct<Step>(kind, rc::gen::inRange(0U, 1000U))));
}

MatrixXd randomMatrix(RandomGenerator& generator, int rows, int columns, double deviation) {
  MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix(i) = sampleNormal(generator, deviation);
  return matrix;
}

class RandomFilters {
 public:
  /// In the background, a global update stays pending until the step that finishes it.
  explicit RandomFilters(SerialWorker::Mode mode)
      : filters_(VectorXd::Zero(kVehicleStates),
                 VectorXd::LinSpaced(kVehicleStates, 0.1, 0.6).asDiagonal(), mode),
        in_background_(mode == SerialWorker::Mode::kBackground) {
    holdWorker();
  }

  void apply(const Step& step) {
    generator_.seed(step.chance);
    switch (step.kind) {
      case Kind::kPredict:
        return predict();
      case Kind::kAppend:
        return append();
      case Kind::kRemove:
        if (!filters_.slots().empty()) filters_.remove(anyLandmark());
        return;
      case Kind::kObserve:
        return observe();
      case Kind::kFuse:
        return fuse();
      case Kind::kFix:
        return filters_.update({vehicleRow()});
      case Kind::kInitialise:
        return initialise();
      case Kind::kAddVehicleError:
        if (filters_.slots().empty()) return;
        return filters_.addVehicleError(anyLandmark(), randomMatrix(generator_, 2, 1, 1.0), 2);
      case Kind::kRedefineErrors:
        return redefineErrors();
      case Kind::kFade:
        return fade();
      case Kind::kSlip:
        return slip();
      case Kind::kGlobalUpdate:
        filters_.compressed().globalUpdate();
        return;
      case Kind::kFinishGlobalUpdate:
        return finishGlobalUpdate();
    }
  }

  void finishGlobalUpdate() {
    hold_.reset();
    filters_.compressed().finishGlobalUpdate();
    holdWorker();
  }

  const test::FilterPair& pair() const { return filters_; }

 private:
  void holdWorker() {
    if (in_background_) hold_ = std::make_unique<test::WorkerHold>(filters_.compressed());
  }

  int anyLandmark() {
    const auto& slots = filters_.slots();
    const auto index = std::uniform_int_distribution<std::size_t>(0, slots.size() - 1)(generator_);
    return std::next(slots.begin(), static_cast<std::ptrdiff_t>(index))->first;
  }

  void redefineErrors() {
    std::set<int> ids;
    for (int k = 0; k < 3 && !filters_.slots().empty(); ++k) ids.insert(anyLandmark());
    const int states = kVehicleStates + 2 * static_cast<int>(ids.size());
    const MatrixXd T =
        MatrixXd::Identity(states, states) + randomMatrix(generator_, states, states, 0.1);
    filters_.redefineErrors({ids.begin(), ids.end()}, T);
  }

  void predict() {
    const MatrixXd J = MatrixXd::Identity(kVehicleStates, kVehicleStates) +
                       randomMatrix(generator_, kVehicleStates, kVehicleStates, 0.03);
    const MatrixXd root = randomMatrix(generator_, kVehicleStates, 2, 0.05);
    const VectorXd vehicle = J * filters_.full().state().head(kVehicleStates);
    filters_.compressed().predict(vehicle, J, root * root.transpose());
    filters_.full().predict(vehicle, J, root * root.transpose());
  }

  void append() {
    const Vector2d position = randomMatrix(generator_, 2, 1, 10.0);
    filters_.append(position, randomMatrix(generator_, 2, kVehicleStates, 1.0),
                    0.1 * Matrix2d::Identity());
  }

  test::FilterPair::Row vehicleRow() {
    return {randomMatrix(generator_, 2, 1, 0.3),
            randomMatrix(generator_, 2, kVehicleStates, 1.0),
            {},
            0.2 * Matrix2d::Identity()};
  }

  void observe() {
    if (filters_.slots().empty()) return;
    std::vector<test::FilterPair::Row> rows;
    for (int k = 0; k < 3; ++k) {
      rows.push_back(vehicleRow());
      // Of one landmark, and of up to two pairs of other states.
      for (int pair = 0; pair <= k; ++pair) {
        rows.back().H_landmarks.emplace_back(anyLandmark(), randomMatrix(generator_, 2, 2, 1.0));
      }
    }
    filters_.update(rows);
  }

  void fuse() {
    if (filters_.slots().size() < 2) return;
    const int a = anyLandmark();
    int b = a;
    while (b == a) b = anyLandmark();
    filters_.update({{randomMatrix(generator_, 2, 1, 0.1),
                      MatrixXd(2, 0),
                      {{a, Matrix2d::Identity()}, {b, -Matrix2d::Identity()}},
                      1e-2 * Matrix2d::Identity()}});
  }

  void fade() {
    if (filters_.slots().empty()) return;
    const double kept = sampleUniform(generator_, 0.0, 1.0);
    const MatrixXd root = randomMatrix(generator_, 2, 2, 1.0);
    filters_.fade(anyLandmark(), kept, root * root.transpose());
  }

  /// Of the vehicle and up to three landmarks, each once.
  void slip() {
    std::set<int> with_vehicle;
    for (int k = 0; k < 3 && !filters_.slots().empty(); ++k) with_vehicle.insert(anyLandmark());
    const MatrixXd root = randomMatrix(generator_, 3, 3, 0.2);
    filters_.addRigidNoise({with_vehicle.begin(), with_vehicle.end()}, root * root.transpose());
  }

  void initialise() {
    const MatrixXd G = randomMatrix(generator_, 2, kVehicleStates, 1.0);
    const Vector2d value = randomMatrix(generator_, 2, 1, 1.0);
    const Matrix2d noise = 0.3 * Matrix2d::Identity();
    filters_.compressed().initialiseVehicleStates(4, value, G, noise);
    filters_.full().initialiseVehicleStates(4, value, G, noise);
  }

  RandomGenerator generator_;
  test::FilterPair filters_;
  bool in_background_;
  std::unique_ptr<test::WorkerHold> hold_;
};

void assertEqual(const test::FilterDifference& difference) {
  RC_ASSERT(difference.state < kExact);
  RC_ASSERT(difference.covariance < kExact);
}

RC_GTEST_PROP(CompressedEkf, EqualsTheFullEkfAfterAnyHistory, ()) {
  RandomFilters filters(SerialWorker::Mode::kInline);
  for (const Step& step : *anyHistory()) filters.apply(step);
  assertEqual(filters.pair().difference());
}

RC_GTEST_PROP(CompressedEkf, EqualsTheFullEkfWhileAGlobalUpdateIsPending, ()) {
  RandomFilters filters(SerialWorker::Mode::kBackground);
  for (const Step& step : *anyHistory()) filters.apply(step);
  filters.apply({Kind::kGlobalUpdate, 0});
  assertEqual(filters.pair().difference());
  filters.finishGlobalUpdate();
  assertEqual(filters.pair().difference());
}

RC_GTEST_PROP(CompressedEkf, KeepsItsCovarianceSymmetricAndPositive, ()) {
  RandomFilters filters(SerialWorker::Mode::kInline);
  for (const Step& step : *anyHistory()) filters.apply(step);
  const test::FilterDifference difference = filters.pair().difference();
  // Symmetric to rounding only: a block of two passive landmarks is a product.
  RC_ASSERT(difference.asymmetry < 1e-12);
  RC_ASSERT(difference.least_eigenvalue > -1e-12);
}

RC_GTEST_PROP(CompressedEkf, EqualsTheFullEkfAlsoWhenSlotsAreUsedAgain, ()) {
  RandomFilters filters(SerialWorker::Mode::kInline);
  for (unsigned i = 0; i < 6; ++i) filters.apply({Kind::kAppend, i});
  for (const unsigned chance :
       *rc::gen::container<std::vector<unsigned>>(8, rc::gen::inRange(0U, 1000U))) {
    filters.apply({Kind::kRemove, chance});
    filters.apply({Kind::kObserve, chance});
    filters.apply({Kind::kGlobalUpdate, chance});
    filters.apply({Kind::kAppend, chance});
    filters.apply({Kind::kPredict, chance});
    filters.apply({Kind::kObserve, chance});
  }
  // No slot was wasted: six landmarks live in at most seven.
  for (const auto& [id, slot] : filters.pair().slots()) RC_ASSERT(slot < 7);
  assertEqual(filters.pair().difference());
}

TEST(CompressedEkf, EqualsTheFullEkfOnADriveWithGpsAndCalibration) {
  test::ShadowedDrive drive(1);
  int global_updates = 0;
  for (int i = 0; i < 400; ++i) {
    if (!drive.step()) continue;
    ++global_updates;
    const test::FilterDifference difference = drive.filters().difference();
    ASSERT_LT(difference.state, kExact) << "step " << i;
    ASSERT_LT(difference.covariance, kExact) << "step " << i;
    ASSERT_GT(difference.least_eigenvalue, -1e-12) << "step " << i;
  }
  EXPECT_GT(global_updates, 5);
  EXPECT_LT(drive.positionError(), 2.0);  // it is a filter that works, too
}

}  // namespace
}  // namespace hymm::core
