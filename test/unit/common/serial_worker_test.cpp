#include "common/serial_worker.h"

#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

class SerialWorkerTest : public testing::TestWithParam<SerialWorker::Mode> {};

TEST_P(SerialWorkerTest, DoesJobsInOrder) {
  SerialWorker worker(GetParam());
  std::vector<int> done;
  for (int i = 0; i < 100; ++i) worker.run([&done, i] { done.push_back(i); });
  worker.wait();
  ASSERT_EQ(done.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(worker.pending(), 0U);
}

TEST_P(SerialWorkerTest, ThrowsOnceWhatAJobThrewAndGoesOn) {
  SerialWorker worker(GetParam());
  int done = 0;
  worker.run([] { throw std::runtime_error("no memory"); });
  worker.run([&done] { ++done; });
  EXPECT_THROW(worker.wait(), std::runtime_error);
  EXPECT_NO_THROW(worker.wait());
  EXPECT_EQ(done, 1);
}

TEST_P(SerialWorkerTest, CountsTheTimeOfItsJobs) {
  SerialWorker worker(GetParam());
  EXPECT_EQ(worker.cpu_s(), 0.0);
  worker.run([] {
    volatile double sum = 0.0;
    for (int i = 0; i < 1000000; ++i) sum = sum + 1.0;
  });
  worker.wait();
  EXPECT_GT(worker.cpu_s(), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(BothModes, SerialWorkerTest,
                         testing::Values(SerialWorker::Mode::kInline,
                                         SerialWorker::Mode::kBackground));

TEST(SerialWorker, LeavesItsCallerAlone) {
  SerialWorker worker(SerialWorker::Mode::kBackground);
  std::promise<void> gate;
  std::thread::id ran_on;
  worker.run([&] {
    gate.get_future().wait();
    ran_on = std::this_thread::get_id();
  });
  EXPECT_EQ(worker.pending(), 1U);  // and this thread goes on
  gate.set_value();
  worker.wait();
  EXPECT_NE(ran_on, std::this_thread::get_id());
}

TEST(SerialWorker, FinishesItsJobsBeforeItEnds) {
  int done = 0;
  {
    SerialWorker worker(SerialWorker::Mode::kBackground);
    for (int i = 0; i < 10; ++i) worker.run([&done] { ++done; });
  }
  EXPECT_EQ(done, 10);
}

}  // namespace
}  // namespace hymm::core
