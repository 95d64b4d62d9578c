#include <algorithm>
#include <cstdint>
#include <optional>

#include "common/error.h"
#include "common/number_text.h"
#include "datasets/acfr_builder.h"
#include "datasets/acfr_forms.h"
#include "datasets/mat_file.h"

namespace hymm::core {
namespace {

constexpr double kSecondsPerMillisecond = 1e-3;
constexpr double kMetresPerCentimetre = 1e-2;

// The SICK's raw words: 13 bits of range in cm, 3 bits of reflected intensity above them.
constexpr std::uint16_t kRangeBits = 0x1FFF;
constexpr std::uint16_t kIntensityBits = 0xE000;

[[noreturn]] void failLengths(const MatFile& file, const std::string& a, std::size_t size_a,
                              const std::string& b, std::size_t size_b) {
  throw InputError(file.path().string() + ": " + a + " has " + std::to_string(size_a) +
                   " entries, but " + b + " has " + std::to_string(size_b) +
                   "; they must fit, get the file again.");
}

/// Vectors of one file that belong together entry by entry.
std::vector<std::vector<double>> readColumns(const MatFile& file,
                                             const std::vector<std::string>& names) {
  std::vector<std::vector<double>> columns;
  for (const std::string& name : names) {
    columns.push_back(file.readVector(name));
    if (columns.back().size() != columns.front().size()) {
      failLengths(file, names.front(), columns.front().size(), name, columns.back().size());
    }
  }
  return columns;
}

/// A matrix with one scan a row.
MatMatrix readBeams(const MatFile& file, const std::string& name, std::size_t scans) {
  MatMatrix matrix = file.read(name);
  if (matrix.columns != AcfrBuilder::kBeams) {
    throw InputError(file.origin(name) + " has " + std::to_string(matrix.columns) +
                     " columns instead of the 361 beams of a scan; get the file again.");
  }
  if (matrix.rows != scans) failLengths(file, name, matrix.rows, "the scans' time", scans);
  return matrix;
}

AcfrBuilder::Beams beamsOfRow(const MatMatrix& matrix, std::size_t row) {
  AcfrBuilder::Beams beams;
  for (std::size_t i = 0; i < beams.size(); ++i) beams[i] = matrix.at(row, i);
  return beams;
}

void addMotion(const std::vector<std::vector<double>>& columns, double seconds_per_tick,
               const std::string& origin, AcfrBuilder& builder) {
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    builder.addMotion(columns[0][i] * seconds_per_tick, columns[1][i], columns[2][i], origin);
  }
}

void addFixes(const std::vector<std::vector<double>>& columns, double seconds_per_tick,
              const std::string& origin, AcfrBuilder& builder) {
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    builder.addFix(columns[0][i] * seconds_per_tick, columns[2][i], columns[1][i], origin);
  }
}

// --- The car-park form: everything in one file, in seconds and metres, with its event order ------

void addCarParkScans(const MatFile& file, AcfrBuilder& builder) {
  const std::vector<double> times_s = file.readVector("TimeLaser");
  const MatMatrix ranges_m = readBeams(file, "Laser", times_s.size());
  std::optional<MatMatrix> intensities;
  if (file.contains("Intensity")) intensities = readBeams(file, "Intensity", times_s.size());
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const AcfrBuilder::Beams beams = beamsOfRow(ranges_m, i);
    if (intensities) {
      builder.addScan(times_s[i], beams, beamsOfRow(*intensities, i), file.origin("TimeLaser"));
    } else {
      builder.addScan(times_s[i], beams, file.origin("TimeLaser"));
    }
  }
}

AcfrRecording readCarPark(const MatFile& file) {
  AcfrBuilder builder("car park, MATLAB");
  addCarParkScans(file, builder);
  addMotion(readColumns(file, {"Time_VS", "Velocity", "Steering"}), 1.0, file.origin("Time_VS"),
            builder);
  if (file.contains("TimeGPS")) {
    addFixes(readColumns(file, {"TimeGPS", "GPSLat", "GPSLon"}), 1.0, file.origin("TimeGPS"),
             builder);
  }
  const auto order = readColumns(file, {"Time", "Sensor", "Index"});
  for (std::size_t i = 0; i < order[0].size(); ++i) {
    builder.addEvent(order[0][i], order[1][i], order[2][i], file.origin("Time, Sensor, Index"));
  }
  return builder.finish();
}

// --- Victoria Park: a file a sensor, in milliseconds and centimetres, without an order
// ------------

void addRawScans(const MatFile& file, AcfrBuilder& builder) {
  const std::vector<double> times_ms = file.readVector("TLsr");
  const MatMatrix words = readBeams(file, "LASER", times_ms.size());
  const bool has_intensities =
      std::any_of(words.values.begin(), words.values.end(),
                  [](double word) { return word > static_cast<double>(kRangeBits); });
  AcfrBuilder::Beams ranges_m, intensities;
  for (std::size_t i = 0; i < times_ms.size(); ++i) {
    for (std::size_t k = 0; k < AcfrBuilder::kBeams; ++k) {
      const double value = words.at(i, k);
      if (!(value >= 0.0 && value <= 65535.0)) {
        throw InputError(file.origin("LASER") + ", row " + std::to_string(i + 1) + ": " +
                         numberText(value) + " is not a 16-bit range; get the file again.");
      }
      const auto word = static_cast<std::uint16_t>(value);
      ranges_m[k] = static_cast<double>(word & kRangeBits) * kMetresPerCentimetre;
      intensities[k] = static_cast<double>(word & kIntensityBits);
    }
    const double time_s = times_ms[i] * kSecondsPerMillisecond;
    if (has_intensities) {
      builder.addScan(time_s, ranges_m, intensities, file.origin("TLsr"));
    } else {
      builder.addScan(time_s, ranges_m, file.origin("TLsr"));
    }
  }
}

AcfrRecording readVictoriaPark(const MatFile& laser, const MatFile& motion, const MatFile* gps) {
  AcfrBuilder builder("Victoria Park, MATLAB");
  addRawScans(laser, builder);
  addMotion(readColumns(motion, {"time", "speed", "steering"}), kSecondsPerMillisecond,
            motion.origin("time"), builder);
  if (gps != nullptr) {
    addFixes(readColumns(*gps, {"timeGps", "La_m", "Lo_m"}), kSecondsPerMillisecond,
             gps->origin("timeGps"), builder);
  }
  builder.orderByTime();
  return builder.finish();
}

/// The file that holds any of these variables; a complaint about the others comes on reading.
const MatFile* findFileWith(const std::vector<MatFile>& files,
                            const std::vector<std::string>& variables) {
  for (const MatFile& file : files) {
    for (const std::string& variable : variables) {
      if (file.contains(variable)) return &file;
    }
  }
  return nullptr;
}

std::string describe(const std::vector<MatFile>& files) {
  std::string text;
  for (const MatFile& file : files) {
    text += (text.empty() ? "" : ", ") + file.path().string() + " (";
    std::string names;
    for (const std::string& name : file.variables()) names += (names.empty() ? "" : " ") + name;
    text += (names.empty() ? "no variables" : names) + ")";
  }
  return text;
}

}  // namespace

AcfrRecording readAcfrMatlab(const std::vector<std::filesystem::path>& paths) {
  std::vector<MatFile> files;
  for (const auto& path : paths) files.emplace_back(path);
  if (const MatFile* car_park = findFileWith(files, {"TimeLaser", "Laser", "Time_VS"})) {
    return readCarPark(*car_park);
  }
  const MatFile* laser = findFileWith(files, {"LASER", "TLsr"});
  const MatFile* motion = findFileWith(files, {"steering", "speed"});
  if (laser == nullptr || motion == nullptr) {
    const std::string missing = laser != nullptr    ? "dead reckoning (time, speed, steering)"
                                : motion != nullptr ? "the laser (TLsr, LASER)"
                                                    : "the laser or dead reckoning";
    throw InputError("No variables of " + missing + " in " + describe(files) +
                     "; give data_set.mat, or aa3_lsr2.mat, aa3_dr.mat and aa3_gpsx.mat together.");
  }
  return readVictoriaPark(*laser, *motion, findFileWith(files, {"timeGps", "La_m"}));
}

}  // namespace hymm::core
