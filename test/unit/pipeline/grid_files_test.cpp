#include "pipeline/grid_files.h"

#include <limits>

#include <gtest/gtest.h>

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

TEST(GridFiles, MemoryIsLoggedEveryTenSecondsOfEachRecording) {
  MapMemoryLog log;
  for (const double time_s : {100.0, 104.0, 110.0, 119.0, 50.0}) {
    GridMemory memory;
    memory.time_s = time_s;
    memory.ltrs = 2;
    memory.in_ltrs.unpacked_bytes = 3000000;
    memory.waiting_bytes = 500000;
    if (log.isDue(time_s)) log.add(memory);
  }
  EXPECT_EQ(log.text(),
            "t,ltrs,unpacked_mb,packed_mb,packed_from_mb,waiting_mb\n"
            "100,2,3,0,0,0.5\n110,2,3,0,0,0.5\n50,2,3,0,0,0.5\n");
}

}  // namespace
}  // namespace hymm::core
