#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <gmock/gmock.h>

#include "common/error.h"
#include "datasets/acfr_recording.h"
#include "datasets/file_source.h"
#include "datasets/mat_file.h"
#include "support/acfr_files.h"
#include "support/recordings.h"

namespace hymm::core {
namespace {

using test::matRow;
using test::matScans;
using test::MatVariable;
using test::writeMatFile;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr char kCarPark[] = "acfr_carpark_excerpt/data_set_20s.mat";
constexpr float kInf = std::numeric_limits<float>::infinity();

class AcfrMatlab : public testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }

  std::vector<MatVariable> carPark() const {
    return {matRow("TimeLaser", {1.0, 1.2}),
            matScans("Laser", {5.0, 81.9}),
            matScans("Intensity", {8192.0, 0.0}, true),
            matRow("Time_VS", {1.0, 1.1}),
            matRow("Velocity", {2.0, 2.5}),
            matRow("Steering", {0.1, 0.2}),
            matRow("Time", {1.0, 1.0, 1.1, 1.2}),
            matRow("Sensor", {2.0, 3.0, 2.0, 3.0}),
            matRow("Index", {1.0, 1.0, 2.0, 2.0})};
  }

  void writeVictoriaPark() const {
    writeMatFile(path("aa3_lsr2.mat"),
                 {matRow("TLsr", {21000.0, 21200.0}), matScans("LASER", {1234.0, 8191.0}, true)});
    writeMatFile(path("aa3_dr.mat"),
                 {matRow("time", {20975.0, 21000.0, 21025.0}), matRow("speed", {1.0, 2.0, 3.0}),
                  matRow("steering", {0.1, 0.2, 0.3})});
    writeMatFile(path("aa3_gpsx.mat"),
                 {matRow("timeGps", {21010.0}), matRow("La_m", {-67.5}), matRow("Lo_m", {-41.2})});
  }

  /// Without the variable `name`.
  static std::vector<MatVariable> without(std::vector<MatVariable> variables,
                                          const std::string& name) {
    variables.erase(std::remove_if(variables.begin(), variables.end(),
                                   [&](const MatVariable& v) { return v.name == name; }),
                    variables.end());
    return variables;
  }

  void expectRefusal(const std::vector<std::filesystem::path>& inputs,
                     const std::string& part) const {
    EXPECT_THAT(
        [&] { readAcfr(inputs); },
        ThrowsMessage<InputError>(AllOf(HasSubstr(folder_.path().string()), HasSubstr(part))));
  }

  test::TemporaryFolder folder_;
};

TEST_F(AcfrMatlab, VictoriaParkIsInMillisecondsAndCentimetres) {
  writeVictoriaPark();
  const AcfrRecording recording =
      readAcfr({path("aa3_gpsx.mat"), path("aa3_lsr2.mat"), path("aa3_dr.mat")});
  ASSERT_EQ(recording.scans.size(), 2u);
  EXPECT_DOUBLE_EQ(recording.scans[0].time_s, 21.0);
  EXPECT_FLOAT_EQ(recording.scans[0].ranges_m[100], 12.34f);
  EXPECT_EQ(recording.scans[1].ranges_m[100], kInf);
  EXPECT_TRUE(recording.scans[0].intensities.empty());
  EXPECT_DOUBLE_EQ(recording.motion[2].time_s, 21.025);
  EXPECT_DOUBLE_EQ(recording.motion[2].speed_mps, 3.0);
  EXPECT_DOUBLE_EQ(recording.motion[2].steering_rad, 0.3);
  EXPECT_DOUBLE_EQ(recording.fixes[0].north_m, -67.5);
  EXPECT_DOUBLE_EQ(recording.fixes[0].east_m, -41.2);
}

TEST_F(AcfrMatlab, VictoriaParkIsOrderedByTimeWithMotionFirst) {
  writeVictoriaPark();
  std::string order;
  for (const auto& event : readAcfr({folder_.path()}).events) {
    order += "?GML"[static_cast<std::size_t>(event.sensor)];
  }
  EXPECT_EQ(order, "MMLGML");
}

TEST_F(AcfrMatlab, UpperBitsOfRawWordsAreIntensity) {
  writeVictoriaPark();
  writeMatFile(path("aa3_lsr2.mat"), {matRow("TLsr", {21000.0, 21200.0}),
                                      matScans("LASER", {1234.0 + 16384.0, 500.0}, true)});
  const AcfrRecording recording = readAcfr({folder_.path()});
  EXPECT_FLOAT_EQ(recording.scans[0].ranges_m[0], 12.34f);
  EXPECT_FLOAT_EQ(recording.scans[0].intensities.at(0), 16384.0f);
  EXPECT_FLOAT_EQ(recording.scans[1].intensities.at(0), 0.0f);
}

TEST_F(AcfrMatlab, VictoriaParkWithoutGpsHasNoFixes) {
  writeVictoriaPark();
  EXPECT_TRUE(readAcfr({path("aa3_lsr2.mat"), path("aa3_dr.mat")}).fixes.empty());
}

TEST_F(AcfrMatlab, VictoriaParkNeedsLaserAndDeadReckoning) {
  writeVictoriaPark();
  expectRefusal({path("aa3_lsr2.mat")}, "No variables of dead reckoning");
  expectRefusal({path("aa3_dr.mat")}, "No variables of the laser");
  expectRefusal({path("aa3_gpsx.mat")}, "aa3_gpsx.mat (La_m Lo_m timeGps)");
}

TEST_F(AcfrMatlab, CarParkCarriesIntensitiesAndItsEventOrder) {
  const AcfrRecording recording = readAcfr({writeMatFile(path("data_set.mat"), carPark())});
  ASSERT_EQ(recording.scans.size(), 2u);
  EXPECT_FLOAT_EQ(recording.scans[0].intensities.at(360), 8192.0f);
  EXPECT_FLOAT_EQ(recording.scans[0].ranges_m[360], 5.0f);
  EXPECT_EQ(recording.scans[1].ranges_m[0], kInf);
  std::string order;
  for (const auto& event : recording.events) {
    order += "?GML"[static_cast<std::size_t>(event.sensor)];
  }
  EXPECT_EQ(order, "MLML");
  EXPECT_TRUE(recording.counts.empty());
}

TEST_F(AcfrMatlab, CarParkMayHoldGps) {
  auto variables = carPark();
  variables.push_back(matRow("TimeGPS", {1.05}));
  variables.push_back(matRow("GPSLat", {10.0}));
  variables.push_back(matRow("GPSLon", {std::nan("")}));
  const AcfrRecording recording = readAcfr({writeMatFile(path("data_set.mat"), variables)});
  ASSERT_EQ(recording.fixes.size(), 1u);
  EXPECT_DOUBLE_EQ(recording.fixes[0].north_m, 10.0);
  EXPECT_TRUE(std::isnan(recording.fixes[0].east_m));
}

TEST_F(AcfrMatlab, NamesMissingVariable) {
  for (const std::string name : {"TimeLaser", "Laser", "Time_VS", "Steering", "Sensor"}) {
    writeMatFile(path("data_set.mat"), without(carPark(), name));
    expectRefusal({path("data_set.mat")}, "data_set.mat holds no variable " + name);
  }
}

TEST_F(AcfrMatlab, NamesVariablesThatDoNotFitTogether) {
  auto variables = carPark();
  variables[4] = matRow("Velocity", {1.0});
  expectRefusal({writeMatFile(path("data_set.mat"), variables)},
                "Time_VS has 2 entries, but Velocity has 1");
  variables = carPark();
  variables[1] = {"Laser", 2, 3, std::vector<double>(6, 1.0)};
  expectRefusal({writeMatFile(path("data_set.mat"), variables)},
                "variable Laser has 3 columns instead of the 361");
  variables = carPark();
  variables[1] = matScans("Laser", {1.0, 2.0, 3.0});
  expectRefusal({writeMatFile(path("data_set.mat"), variables)}, "Laser has 3 entries");
}

TEST_F(AcfrMatlab, RefusesFileCutOffAnywhere) {
  const auto file = writeMatFile(path("data_set.mat"), carPark());
  const std::string whole = readFile(file);
  for (std::size_t kept = 0; kept < whole.size(); kept += 7) {
    folder_.write("data_set.mat", whole.substr(0, kept));
    EXPECT_THROW(readAcfr({file}), InputError) << kept << " of " << whole.size() << " bytes";
  }
}

/// A file of MATLAB's version 4: five words, the name with its end, then numbers.
std::string version4(const std::array<std::uint32_t, 5>& header, std::size_t numbers) {
  return std::string(reinterpret_cast<const char*>(header.data()), sizeof(header)) +
         std::string("LASER", 6) + std::string(numbers * sizeof(double), '\0');
}

TEST_F(AcfrMatlab, ReadsMatrixOfVersion4) {
  folder_.write("lsr.mat", version4({0, 2, 3, 0, 6}, 6));
  EXPECT_EQ(MatFile(path("lsr.mat")).read("LASER").values, std::vector<double>(6, 0.0));
}

TEST_F(AcfrMatlab, RefusesMatrixThatItsFileCannotHold) {
  for (const auto& header : {std::array<std::uint32_t, 5>{0, 1000, 1000, 0, 6},
                             std::array<std::uint32_t, 5>{0, 0xffffffff, 0xffffffff, 1, 6}}) {
    folder_.write("lsr.mat", version4(header, 1));
    EXPECT_THAT([&] { MatFile file(path("lsr.mat")); },
                ThrowsMessage<InputError>(HasSubstr("within a variable")));
  }
}

TEST_F(AcfrMatlab, RefusesNameThatIsLongerThanAnyIs) {
  folder_.write("lsr.mat", version4({0, 1, 1, 0, 0x7fffffff}, 1));
  expectRefusal({path("lsr.mat")}, "is not a MATLAB file");
}

TEST_F(AcfrMatlab, RefusesOtherVersions) {
  const std::string file = readFile(writeMatFile(path("data_set.mat"), carPark()));
  for (const auto& [at, text] : {std::pair{7, "7.3"}, std::pair{125, "\2"}, std::pair{126, "MI"}}) {
    std::string other = file;
    other.replace(static_cast<std::size_t>(at), std::strlen(text), text);
    folder_.write("data_set.mat", other);
    expectRefusal({path("data_set.mat")}, "save it anew");
  }
}

TEST_F(AcfrMatlab, RefusesStructures) {
  const std::array<std::uint32_t, 10> structure = {14, 32, 6, 8, 2, 0, 5, 8, 1, 1};
  std::string file = readFile(writeMatFile(path("data_set.mat"), carPark())).substr(0, 128);
  file += std::string(reinterpret_cast<const char*>(structure.data()), sizeof(structure));
  folder_.write("data_set.mat", file);
  expectRefusal({path("data_set.mat")}, "with matrices of numbers alone");
}

TEST_F(AcfrMatlab, RefusesCompressedVariableWithAnyBitWrong) {
  const std::string file = readFile(writeMatFile(path("a.mat"), {matRow("LASER", {1.0, 2.0})}));
  ASSERT_EQ(file[128], 15) << "is not compressed";
  for (std::size_t bit = 8 * 128; bit < 8 * file.size(); ++bit) {
    std::string damaged = file;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ 1 << bit % 8);
    folder_.write("a.mat", damaged);
    try {  // the window's size may be larger than needed: the variable is then as it was
      EXPECT_EQ(MatFile(path("a.mat")).read("LASER").values, (std::vector<double>{1.0, 2.0}));
    } catch (const InputError&) {
    }
  }
}

TEST_F(AcfrMatlab, RefusesWhatIsNoMatlabFile) {
  expectRefusal({folder_.write("data_set.mat", std::string(500, 'x'))}, "is not a MATLAB file");
  expectRefusal({path("none.mat")}, "does not exist");
}

TEST(AcfrRecordings, CarParkExcerptHasAllItsRows) {
  HYMM_SKIP_WITHOUT_RECORDING(kCarPark);
  const AcfrRecording recording = readAcfr({test::recording(kCarPark)});
  EXPECT_EQ(recording.scans.size(), 94u);
  EXPECT_EQ(recording.motion.size(), 800u);
  EXPECT_EQ(recording.events.size(), 894u);
  EXPECT_TRUE(recording.counts.empty());
  EXPECT_DOUBLE_EQ(recording.scans[0].time_s, 45.103);
  EXPECT_FLOAT_EQ(recording.scans[0].ranges_m[0], 0.84f);
  EXPECT_DOUBLE_EQ(recording.motion[0].speed_mps, 2.0120826);
  std::size_t reflecting_beams = 0;
  for (const LaserScan& scan : recording.scans) {
    ASSERT_EQ(scan.intensities.size(), scan.ranges_m.size());
    for (const float intensity : scan.intensities) reflecting_beams += intensity >= 8192.0f;
  }
  EXPECT_GT(reflecting_beams, 94u);  // more than one a scan: the poles are in view
}

}  // namespace
}  // namespace hymm::core
