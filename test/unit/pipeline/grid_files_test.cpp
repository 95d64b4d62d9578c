#include "pipeline/grid_files.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "common/stamp_schedule.h"

namespace hymm::core {
namespace {

TEST(GridFiles, LtrsAreLinesOfTheirTopology) {
  LtrTopology ltr;
  ltr.id = 4;
  ltr.landmark_ids = {7, 9, 12};
  ltr.neighbours = {-1, 3, -1};
  ltr.alpha_cells = 40;
  ltr.beta_cells = 50;
  ltr.observations = 12.5;
  ltr.shape_factor = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ltrsText({ltr}),
            "id,landmark_1,landmark_2,landmark_3,neighbour_12,neighbour_23,neighbour_31,"
            "alpha_cells,beta_cells,observations,shape_factor\n"
            "4,7,9,12,-1,3,-1,40,50,12.5,nan\n");
}

TEST(GridFiles, MemoryIsToldInMegabytes) {
  MapMemoryLog log;
  GridMemory memory;
  memory.time_s = 100.0;
  memory.ltrs = 2;
  memory.in_ltrs = {3000000, 250000, 1000000};
  memory.waiting_bytes = 500000;
  log.add(memory);
  EXPECT_EQ(log.text(),
            "t,ltrs,unpacked_mb,packed_mb,packed_from_mb,waiting_mb\n100,2,3,0.25,1,0.5\n");
}

TEST(StampSchedule, IsDueOnceInAPeriodOfEachRecording) {
  StampSchedule schedule(10.0);
  std::vector<double> due;
  for (const double time_s : {100.0, 104.0, 110.0, 119.0, 50.0, 51.0}) {
    if (schedule.takeIfDue(time_s)) due.push_back(time_s);
  }
  EXPECT_EQ(due, (std::vector<double>{100.0, 110.0, 50.0}));
}

}  // namespace
}  // namespace hymm::core
