#include "cekf/active_area.h"

#include <chrono>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "support/worker_hold.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ActiveAreaConfig smallArea() {
  ActiveAreaConfig config;
  config.cell_m = 10.0;
  config.hysteresis_m = 1.0;
  config.max_origin_states = 32;
  return config;
}

/// A filter with landmarks that are passive, whose worker is in the background.
CompressedEkf filterWith(int landmarks) {
  CompressedEkf filter(VectorXd::Zero(3), MatrixXd::Identity(3, 3),
                       SerialWorker::Mode::kBackground);
  for (int i = 0; i < landmarks; ++i) {
    filter.append({1.0 * i, 0.0}, MatrixXd::Zero(2, 3), Matrix2d::Identity());
  }
  filter.globalUpdate();
  filter.finishGlobalUpdate();
  return filter;
}

void activate(CompressedEkf& filter, int landmarks) {
  for (int slot = 0; slot < landmarks; ++slot) filter.activate(slot);
}

TEST(ActiveArea, FollowsTheVehicleBeyondItsCellAndHysteresis) {
  ActiveArea area(smallArea());
  EXPECT_FALSE(area.follow({5.9, 0.0}));
  EXPECT_TRUE(area.follow({6.1, 0.0}));
  EXPECT_FALSE(area.follow({4.1, 0.0}));  // the cell around (10, 0), with its hysteresis
  EXPECT_EQ(area.counts().switches, 1U);
}

TEST(ActiveArea, UpdatesWhenTooManyLandmarksHaveComeIntoTheMap) {
  CompressedEkf filter = filterWith(0);
  ActiveArea area(smallArea());
  for (int i = 0; i < 16; ++i)
    filter.append({1.0 * i, 0.0}, MatrixXd::Zero(2, 3), Matrix2d::Identity());
  area.updateIfDue(filter);
  EXPECT_EQ(area.counts().global_updates, 0U);
  filter.append({0.0, 5.0}, MatrixXd::Zero(2, 3), Matrix2d::Identity());
  area.updateIfDue(filter);
  EXPECT_EQ(area.counts().global_updates, 1U);
  EXPECT_EQ(filter.activeCount(), 0U);
}

TEST(ActiveArea, UpdatesWhenTheVehicleHasLeftItsCellAndNotBefore) {
  CompressedEkf filter = filterWith(3);
  ActiveArea area(smallArea());
  area.updateIfDue(filter);
  EXPECT_EQ(area.counts().global_updates, 0U);
  area.follow({20.0, 0.0});
  area.updateIfDue(filter);
  area.updateIfDue(filter);
  EXPECT_EQ(area.counts().global_updates, 1U);
}

TEST(ActiveArea, DefersAnUpdateWhileOneIsPendingAndCountsItOnce) {
  CompressedEkf filter = filterWith(20);
  ActiveArea area(smallArea());
  {
    const test::WorkerHold hold(filter);
    filter.globalUpdate();
    area.demandUpdate();
    area.updateIfDue(filter);
    activate(filter, 20);
    area.updateIfDue(filter);
    EXPECT_EQ(area.counts().deferred, 1U);
    EXPECT_EQ(area.counts().waits, 0U);
    EXPECT_EQ(area.counts().global_updates, 0U);
    EXPECT_EQ(filter.activeCount(), 20U);
  }
  filter.finishGlobalUpdate();
  area.updateIfDue(filter);
  EXPECT_EQ(area.counts().global_updates, 1U);
  EXPECT_EQ(area.counts().deferred, 1U);
  EXPECT_EQ(filter.activeCount(), 0U);
}

TEST(ActiveArea, WaitsForThePendingUpdateWhenTheActivePartIsFull) {
  CompressedEkf filter = filterWith(40);
  ActiveArea area(smallArea());
  auto hold = std::make_unique<test::WorkerHold>(filter);
  filter.globalUpdate();
  activate(filter, 31);  // 65 origin states
  std::thread release([&hold] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    hold.reset();
  });
  area.updateIfDue(filter);
  release.join();
  EXPECT_EQ(area.counts().waits, 1U);
  EXPECT_EQ(area.counts().global_updates, 1U);
  EXPECT_EQ(filter.activeCount(), 0U);
}

}  // namespace
}  // namespace hymm::core
