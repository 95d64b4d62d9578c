#include <algorithm>

#include "common/error.h"
#include "datasets/acfr_builder.h"
#include "datasets/acfr_forms.h"
#include "datasets/number_table.h"

namespace hymm::core {
namespace {

struct NamedTable {
  std::string origin;
  NumberTable numbers;
};

NamedTable readTable(const FileSource& source, const std::string& name, std::size_t columns,
                     RowEnd row_end) {
  const std::string origin = source.origin(name);
  NamedTable table{origin, parseNumberTable(source.read(name), columns, row_end, origin)};
  if (table.numbers.rows() == 0) {
    throw InputError(origin + " holds no rows; give the complete recording.");
  }
  return table;
}

void addScans(const NamedTable& table, AcfrBuilder& builder) {
  AcfrBuilder::Beams ranges_m;
  for (std::size_t i = 0; i < table.numbers.rows(); ++i) {
    const double* row = &table.numbers.values[i * table.numbers.columns];
    std::copy(row + 1, row + table.numbers.columns, ranges_m.begin());
    builder.addScan(row[0], ranges_m, table.origin);
  }
}

void addFixes(const FileSource& source, AcfrBuilder& builder) {
  const NamedTable gps = readTable(source, "GPS.txt", 3, RowEnd::kLine);  // north, east
  for (std::size_t i = 0; i < gps.numbers.rows(); ++i) {
    builder.addFix(gps.numbers.at(i, 0), gps.numbers.at(i, 2), gps.numbers.at(i, 1), gps.origin);
  }
}

void addOrder(const FileSource& source, AcfrBuilder& builder) {
  const NamedTable order = readTable(source, "Sensors_manager.txt", 3, RowEnd::kLine);
  for (std::size_t i = 0; i < order.numbers.rows(); ++i) {
    builder.addEvent(order.numbers.at(i, 0), order.numbers.at(i, 1), order.numbers.at(i, 2),
                     order.origin);
  }
}

}  // namespace

AcfrRecording readAcfrAscii(const FileSource& source) {
  // time, then the ranges; the published file has no line breaks at all
  const NamedTable laser =
      readTable(source, kAcfrAsciiLaserFile, 1 + AcfrBuilder::kBeams, RowEnd::kLastNumber);
  const NamedTable motion = readTable(source, "DRS.txt", 3, RowEnd::kLine);  // speed, steering

  AcfrBuilder builder("Victoria Park, ASCII");
  builder.reserve(laser.numbers.rows(), motion.numbers.rows());
  addScans(laser, builder);
  for (std::size_t i = 0; i < motion.numbers.rows(); ++i) {
    builder.addMotion(motion.numbers.at(i, 0), motion.numbers.at(i, 1), motion.numbers.at(i, 2),
                      motion.origin);
  }
  if (source.contains("GPS.txt")) addFixes(source, builder);
  if (source.contains("Sensors_manager.txt")) {
    addOrder(source, builder);
  } else {
    builder.orderByTime();
  }
  return builder.finish();
}

}  // namespace hymm::core
