#include "pipeline/suite_config.h"

#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(SuiteConfig, LaterFilesOverrideSingleParameters) {
  const test::TemporaryFolder folder;
  const std::string first = folder.write("first.yaml", "vehicle: {length_m: 5.0, width_m: 2.0}\n");
  const std::string second = folder.write("second.yaml", "vehicle: {width_m: 1.5}\n");
  ConfigReport report;
  const SuiteConfig config = loadSuiteConfig({first, second}, report);
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_THAT(report.warnings, IsEmpty());
  EXPECT_EQ(config.vehicle.length_m, 5.0);
  EXPECT_EQ(config.vehicle.width_m, 1.5);
}

TEST(SuiteConfig, NamedVehicleIsFoundBesideTheOverlay) {
  const test::TemporaryFolder folder;
  folder.write("vehicles/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string overlay = folder.write("datasets/yard.yaml",
                                           "vehicle: cart\n"
                                           "cekf_slam: {motion_input: odom}\n");
  ConfigReport report;
  const SuiteConfig config = loadSuiteConfig({overlay}, report);
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_EQ(config.vehicle.length_m, 1.25);
  EXPECT_EQ(config.cekf_slam.motion_input, "odom");
}

TEST(SuiteConfig, NamedVehicleIsFoundInTheConfigFolder) {
  const test::TemporaryFolder folder;
  folder.write("config/vehicles/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string overlay = folder.write("mine.yaml", "vehicle: cart\n");
  ConfigReport report;
  const SuiteConfig config = loadSuiteConfig({overlay}, report, [&] { return folder / "config"; });
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_EQ(config.vehicle.length_m, 1.25);
}

TEST(SuiteConfig, VehicleMayBeAPath) {
  const test::TemporaryFolder folder;
  folder.write("robots/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string overlay = folder.write("mine.yaml", "vehicle: robots/cart.yaml\n");
  ConfigReport report;
  EXPECT_EQ(loadSuiteConfig({overlay}, report).vehicle.length_m, 1.25);
  EXPECT_THAT(report.errors, IsEmpty());
}

TEST(SuiteConfig, VehiclePathIsRelativeToTheOverlayThenToTheConfigFolder) {
  const test::TemporaryFolder folder;
  folder.write("config/vehicles/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string overlay = folder.write("mine/overlay.yaml", "vehicle: vehicles/cart.yaml\n");
  const auto config_folder = [&] { return folder / "config"; };
  ConfigReport report;
  EXPECT_EQ(loadSuiteConfig({overlay}, report, config_folder).vehicle.length_m, 1.25);
  folder.write("mine/vehicles/cart.yaml", "vehicle: {length_m: 2.5}\n");
  EXPECT_EQ(loadSuiteConfig({overlay}, report, config_folder).vehicle.length_m, 2.5);
  EXPECT_THAT(report.errors, IsEmpty());
}

TEST(SuiteConfig, VehiclePathMayBeAbsolute) {
  const test::TemporaryFolder folder;
  const std::string cart = folder.write("robots/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string overlay = folder.write("mine/overlay.yaml", "vehicle: " + cart + "\n");
  ConfigReport report;
  EXPECT_EQ(loadSuiteConfig({overlay}, report).vehicle.length_m, 1.25);
  EXPECT_THAT(report.errors, IsEmpty());
}

TEST(SuiteConfig, ForAVehicleThatIsNotFoundTellsTheKnownOnes) {
  const test::TemporaryFolder folder;
  folder.write("config/vehicles/truck.yaml", "vehicle: {length_m: 9}\n");
  folder.write("config/vehicles/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string overlay = folder.write("mine.yaml", "vehicle: crat\n");
  ConfigReport report;
  loadSuiteConfig({overlay}, report, [&] { return folder / "config"; });
  EXPECT_THAT(report.errors, ElementsAre(AllOf(HasSubstr("'crat'"), HasSubstr(overlay),
                                               HasSubstr("config/vehicles/crat.yaml"),
                                               HasSubstr("Known by name: cart, truck."))));
}

TEST(SuiteConfig, NamedVehicleReplacesTheOneBefore) {
  const test::TemporaryFolder folder;
  folder.write("vehicles/cart.yaml", "vehicle: {length_m: 1.25}\n");
  const std::string first = folder.write("datasets/a.yaml", "vehicle: {width_m: 0.5}\n");
  const std::string second = folder.write("datasets/b.yaml", "vehicle: cart\n");
  ConfigReport report;
  const SuiteConfig config = loadSuiteConfig({first, second}, report);
  EXPECT_EQ(config.vehicle.width_m, VehicleConfig().width_m);
}

TEST(SuiteConfig, KnowsWhetherAFileTellsWhereTheLaserStands) {
  const test::TemporaryFolder folder;
  folder.write("vehicles/blind.yaml", "vehicle: {length_m: 1.25}\n");
  folder.write("vehicles/cart.yaml", "vehicle: {laser: {x_m: 0.5}}\n");
  const std::string blind = folder.write("datasets/blind.yaml", "vehicle: blind\n");
  const std::string cart = folder.write("datasets/cart.yaml", "vehicle: cart\n");
  const std::string overlay = folder.write("overlay.yaml", "vehicle: {laser: {y_m: 0.1}}\n");
  ConfigReport report;
  EXPECT_FALSE(loadSuiteConfig({blind}, report).vehicle_tells_laser);
  EXPECT_TRUE(loadSuiteConfig({cart}, report).vehicle_tells_laser);
  EXPECT_TRUE(loadSuiteConfig({blind, overlay}, report).vehicle_tells_laser);
  EXPECT_FALSE(loadSuiteConfig({cart, blind}, report).vehicle_tells_laser);
}

TEST(SuiteConfig, ListsAllErrorsWithTheirFiles) {
  const test::TemporaryFolder folder;
  const std::string bad = folder.write("bad.yaml",
                                       "vehicle: {length_m: -1, width_m: wide}\n"
                                       "cekf_slam: {motion_input: legs}\n");
  const std::string broken = folder.write("broken.yaml", "vehicle: {\n");
  const std::string missing = folder / "missing.yaml";
  const std::string unknown = folder.write("unknown.yaml", "vehicle: hovercraft\n");
  ConfigReport report;
  loadSuiteConfig({bad, broken, missing, unknown}, report);
  EXPECT_THAT(report.errors, ElementsAre(AllOf(HasSubstr(bad), HasSubstr("vehicle.length_m")),
                                         AllOf(HasSubstr(bad), HasSubstr("vehicle.width_m")),
                                         AllOf(HasSubstr(bad), HasSubstr("cekf_slam.motion_input")),
                                         HasSubstr(broken), HasSubstr(missing),
                                         AllOf(HasSubstr(unknown), HasSubstr("hovercraft.yaml"))));
}

TEST(SuiteConfig, UnknownNamesWarnWithTheNearestKnownOne) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("a.yaml",
                                        "cekf_slm: {motion_input: odom}\n"
                                        "vehicle: {lenght_m: 2.0}\n");
  ConfigReport report;
  loadSuiteConfig({file}, report);
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_THAT(report.warnings, ElementsAre(HasSubstr("did you mean 'cekf_slam'?"),
                                           HasSubstr("did you mean 'vehicle.length_m'?")));
}

TEST(SuiteConfig, RefusesNamesThatAreGivenTwice) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write(
      "twice.yaml", "cekf_slam:\n  motion_input: odom\n  motion_input: dead_reckoning\n");
  ConfigReport report;
  loadSuiteConfig({file}, report);
  EXPECT_THAT(report.errors,
              ElementsAre(file + ": 'cekf_slam.motion_input' is given twice; keep one of them."));
}

TEST(SuiteConfig, RefusesAFolderInPlaceOfAFile) {
  const test::TemporaryFolder folder;
  ConfigReport report;
  loadSuiteConfig({folder.path().string()}, report);
  EXPECT_THAT(report.errors,
              ElementsAre(folder.path().string() + ": is a folder; a YAML file is needed."));
}

TEST(SuiteConfig, ReadsAFileWhoseAliasLeadsBackToItself) {
  const test::TemporaryFolder folder;
  ConfigReport report;
  loadSuiteConfig({folder.write("loop.yaml", "a: &a {b: *a}\n")}, report);
  EXPECT_THAT(report.errors, IsEmpty());
}

TEST(SuiteConfig, AFileThatHoldsNoParametersIsAnError) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("a.yaml", "- a list\n");
  ConfigReport report;
  loadSuiteConfig({file}, report);
  EXPECT_THAT(report.errors, SizeIs(1));
}

TEST(SuiteConfig, EveryShippedConfigurationLoadsWithoutWarning) {
  const char* source_dir = std::getenv("HYMM_SOURCE_DIR");
  ASSERT_NE(source_dir, nullptr);
  const std::filesystem::path folder = std::filesystem::path(source_dir) / "config";
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    ++files;
    ConfigReport report;
    loadSuiteConfig({entry.path().string()}, report, [&] { return folder.string(); });
    EXPECT_THAT(report.errors, IsEmpty()) << entry.path();
    EXPECT_THAT(report.warnings, IsEmpty()) << entry.path();
  }
  EXPECT_GE(files, 1u);
}

}  // namespace
}  // namespace hymm::core
