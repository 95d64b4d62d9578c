// The tool hymm_benchmark: Google Benchmark with plain names and a few options of its own.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmark/benchmarks.h"
#include "benchmark/plain_names.h"

namespace hymm::benchmarks {
namespace {

struct Options {
  ScanOptions scan;
  std::string filter;
  std::string out_format = "json";
  bool list = false;
  bool writes_file = false;
};

void printHelp() {
  std::puts(
      "hymm_benchmark: how fast hymm's parts are, beside their peers.\n"
      "\n"
      "Options of its own:\n"
      "  --scans=NUMBER        scans that BM_ScanCompressedEkf drives (default 700: over 20 area\n"
      "                        switches); BM_ScanFullEkf drives as many of them as bearable\n"
      "  --live_speed=FACTOR   pace of the scans, times 4.67 Hz (default 2); 0: no pause\n"
      "  --stay_awake          until a scan is due, asks for the time instead of sleeping, which\n"
      "                        tells how much of a scan is the processor's waking up\n"
      "  --perf_control=FIFO   tells `perf record --control fifo:FIFO -D -1` when the drive of\n"
      "                        BM_ScanCompressedEkf begins and ends\n"
      "\n"
      "Options of Google Benchmark:");
  benchmark::PrintDefaultHelp();
}

/// The value of `--name=value`, or null if the argument is another.
const char* valueOf(const char* argument, const char* name) {
  const std::size_t length = std::strlen(name);
  return std::strncmp(argument, name, length) == 0 && argument[length] == '='
             ? argument + length + 1
             : nullptr;
}

double numberOf(const char* text, const char* option) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0' || !(value >= 0.0)) {
    throw std::invalid_argument(std::string(option) +
                                " wants a number that is not negative, not '" + text + "'");
  }
  return value;
}

/// Takes out of argv what is not for Google Benchmark.
Options takeOptions(int& argc, char** argv) {
  Options options;
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const char* value = nullptr;
    if ((value = valueOf(argv[i], "--scans")) != nullptr) {
      options.scan.scans = static_cast<int>(numberOf(value, "--scans"));
    } else if ((value = valueOf(argv[i], "--live_speed")) != nullptr) {
      options.scan.live_speed = numberOf(value, "--live_speed");
    } else if (std::strcmp(argv[i], "--stay_awake") == 0) {
      options.scan.stays_awake = true;
    } else if ((value = valueOf(argv[i], "--perf_control")) != nullptr) {
      options.scan.perf_control = value;
    } else if ((value = valueOf(argv[i], "--benchmark_filter")) != nullptr) {
      options.filter = value;
    } else if (std::strcmp(argv[i], "--benchmark_list_tests") == 0 ||
               std::strcmp(argv[i], "--benchmark_list_tests=true") == 0) {
      options.list = true;
    } else {
      if (valueOf(argv[i], "--benchmark_out") != nullptr) options.writes_file = true;
      value = valueOf(argv[i], "--benchmark_out_format");
      if (value != nullptr) options.out_format = value;
      argv[kept++] = argv[i];
    }
  }
  argc = kept;
  if (options.scan.scans < 1) throw std::invalid_argument("--scans must be at least 1");
  return options;
}

int run(int argc, char** argv) {
  Options options = takeOptions(argc, argv);
  benchmark::Initialize(&argc, argv, printHelp);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;

  Registration registration(options.filter);
  registerScanBenchmarks(registration, options.scan);
  registerGlobalUpdateBenchmarks(registration);
  registerAssociationBenchmarks(registration);
  registerLevelSetBenchmarks(registration);
  registerDoorPlannerBenchmarks(registration);
  registerParticleBenchmarks(registration);
  registerMapCorrectionBenchmarks(registration);
  registerRayInsertionBenchmarks(registration);
  if (registration.names().empty()) {
    std::fprintf(stderr, "No benchmark is called '%s'; --benchmark_list_tests names all.\n",
                 options.filter.c_str());
    return 1;
  }
  if (options.list) {
    for (const std::string& name : registration.names()) std::puts(name.c_str());
    return 0;
  }
  PlainNameReporter display(
      std::unique_ptr<benchmark::BenchmarkReporter>(benchmark::CreateDefaultDisplayReporter()));
  if (options.writes_file && options.out_format == "json") {
    PlainNameReporter file(std::make_unique<benchmark::JSONReporter>());
    benchmark::RunSpecifiedBenchmarks(&display, &file, "all");
  } else {
    benchmark::RunSpecifiedBenchmarks(&display, "all");
  }
  benchmark::Shutdown();
  return 0;
}

}  // namespace
}  // namespace hymm::benchmarks

int main(int argc, char** argv) {
  try {
    return hymm::benchmarks::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hymm_benchmark: %s\n", error.what());
    return 2;
  }
}
