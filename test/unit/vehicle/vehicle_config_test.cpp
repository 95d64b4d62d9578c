#include "vehicle/vehicle_config.h"

#include <cstdlib>
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vehicle/motion_model.h"

namespace hymm::core {
namespace {

std::vector<std::filesystem::path> shippedVehicles() {
  const char* source = std::getenv("HYMM_SOURCE_DIR");
  if (source == nullptr) return {};
  std::vector<std::filesystem::path> files;
  const auto folder = std::filesystem::path(source) / "config" / "vehicles";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  return files;
}

TEST(VehicleConfig, ShipsOnlyVehiclesThatLoadWithoutAWarning) {
  const auto files = shippedVehicles();
  ASSERT_FALSE(files.empty());
  for (const auto& file : files) {
    VehicleConfig vehicle;
    ConfigReport report;
    readConfig(YAML::LoadFile(file.string())["vehicle"], vehicle, file.filename().string(), report);
    EXPECT_THAT(report.errors, testing::IsEmpty());
    EXPECT_THAT(report.warnings, testing::IsEmpty());
    EXPECT_EQ(vehicle.name, file.stem().string());
    EXPECT_NO_THROW(MotionModel{vehicle});
  }
}

TEST(VehicleConfig, DescribesEachParameterOnceWithAMeaning) {
  VehicleConfig vehicle;
  ConfigSchema schema;
  vehicle.describe(schema);
  std::set<std::string> paths;
  std::set<const void*> fields;
  for (const auto& entry : schema.entries()) {
    EXPECT_TRUE(paths.insert(entry.path).second) << entry.path;
    const void* field = std::visit([](auto* value) -> const void* { return value; }, entry.value);
    EXPECT_TRUE(fields.insert(field).second) << entry.path;
    EXPECT_FALSE(entry.meaning.empty()) << entry.path;
  }
}

TEST(VehicleConfig, AcceptsItsOwnDefaults) {
  VehicleConfig vehicle;
  ConfigSchema schema;
  vehicle.describe(schema);
  for (const auto& entry : schema.entries()) {
    if (const auto* number = std::get_if<double*>(&entry.value)) {
      EXPECT_TRUE(entry.range.contains(**number)) << entry.path;
    }
  }
}

TEST(VehicleConfig, RefusesImpossibleBodies) {
  VehicleConfig vehicle;
  ConfigReport report;
  readConfig(YAML::Load("{length_m: 0, width_m: -1, max_steering_rad: 1.6,"
                        " ackermann: {wheelbase_m: 0}, noise: {correlation_time_s: 0},"
                        " laser: {yaw_rad: 4}}"),
             vehicle, "car.yaml", report);
  EXPECT_EQ(report.errors.size(), 6U);
}

TEST(MotionNoise, PersistsAsLongForAllErrorsUnlessTold) {
  MotionNoise noise;
  noise.correlation_time_s = 0.3;
  EXPECT_EQ(noise.correlationTimes_s(), Eigen::Vector3d(0.3, 0.3, 0.3));
  noise.speed_correlation_time_s = 1.2;
  noise.turn_relative_correlation_time_s = 5.0;
  EXPECT_EQ(noise.correlationTimes_s(), Eigen::Vector3d(1.2, 0.3, 5.0));
}

}  // namespace
}  // namespace hymm::core
