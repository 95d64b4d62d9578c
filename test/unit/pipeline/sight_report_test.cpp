#include "pipeline/sight_report.h"

#include <limits>

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

CekfSlam::Counts countsOf(std::size_t scans, std::size_t observations, std::size_t created) {
  CekfSlam::Counts counts;
  counts.scans = scans;
  counts.observations = observations;
  counts.landmarks_created = created;
  return counts;
}

PerceptionConfig reflectors(double min_intensity) {
  PerceptionConfig config;
  config.reflectors.enabled = true;
  config.reflectors.min_intensity = min_intensity;
  return config;
}

/// The last beam met nothing.
LaserScan scanOf(std::vector<float> intensities) {
  LaserScan scan;
  scan.angle_increment_rad = 0.1;
  scan.range_max_m = 30.0;
  scan.ranges_m.assign(intensities.size(), 5.0F);
  scan.ranges_m.back() = std::numeric_limits<float>::infinity();
  scan.intensities = std::move(intensities);
  return scan;
}

TEST(SightReport, SaysThatARunWithoutLandmarksIsDeadReckoning) {
  const SightReport report{PerceptionConfig()};
  EXPECT_THAT(report.sentences(countsOf(700, 0, 0), 0),
              ElementsAre(AllOf(HasSubstr("no landmark was found in 700 scans (nothing"),
                                HasSubstr("dead reckoning"))));
  EXPECT_THAT(report.sentences(countsOf(700, 9, 0), 0),
              ElementsAre(HasSubstr("not seen often enough")));
  EXPECT_THAT(report.sentences(countsOf(700, 900, 3), 3), IsEmpty());
  EXPECT_THAT(report.sentences(countsOf(700, 900, 0), 5), IsEmpty());  // of a map that was loaded
  EXPECT_THAT(report.sentences(countsOf(0, 0, 0), 0), IsEmpty());      // an error of its own
}

TEST(SightReport, TellsTheLargestIntensityWhereNoneIsEnough) {
  SightReport report(reflectors(8192.0));
  report.take(scanOf({0.25F, 0.75F, std::numeric_limits<float>::quiet_NaN(), 255.0F}));
  EXPECT_THAT(report.sentences(countsOf(1, 1, 1), 1),
              ElementsAre(AllOf(HasSubstr("largest intensity of 1 scans is 0.75"),
                                HasSubstr("min_intensity 8192"))));
  report.take(scanOf({8192.0F, 0.0F}));
  EXPECT_THAT(report.sentences(countsOf(2, 1, 1), 1), IsEmpty());
}

TEST(SightReport, SaysThatReflectorsCannotBeSeenWithoutIntensities) {
  SightReport report(reflectors(1.0));
  EXPECT_THAT(report.sentences(countsOf(1, 1, 1), 1), IsEmpty());  // detections, no scans
  LaserScan scan = scanOf({0.0F, 0.0F});
  scan.intensities.clear();
  report.take(scan);
  EXPECT_THAT(report.sentences(countsOf(1, 1, 1), 1),
              ElementsAre(HasSubstr("reflectors cannot be seen: none of 1 scans")));
}

TEST(SightReport, DoesNotMindIntensitiesThatNobodyAsksFor) {
  SightReport report{PerceptionConfig()};
  report.take(scanOf({0.5F, 0.5F}));
  EXPECT_THAT(report.sentences(countsOf(1, 1, 1), 1), IsEmpty());
}

}  // namespace
}  // namespace hymm::core
