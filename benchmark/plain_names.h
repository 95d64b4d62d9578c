#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

namespace hymm::benchmarks {

/// Names benchmarks so that what is printed, listed and filtered is the plain name, without the
/// suffixes that Google Benchmark appends for fixed iterations and manual time.
class Registration {
 public:
  /// `filter`: a regular expression that a part of the name must match; a leading '-' turns it
  /// round. Throws std::regex_error if it is none.
  explicit Registration(std::string filter) : filter_(std::move(filter)) {}

  /// Calls `configure` with the new benchmark if the filter lets it through.
  template <typename Function, typename Configure>
  void add(const std::string& name, Function&& function, Configure&& configure) {
    if (!matches(name)) return;
    names_.push_back(name);
    configure(benchmark::RegisterBenchmark(name.c_str(), std::forward<Function>(function)));
  }

  const std::vector<std::string>& names() const { return names_; }

 private:
  bool matches(const std::string& name) const;

  std::string filter_;
  std::vector<std::string> names_;
};

/// A reporter that passes everything on to another, with plain names.
class PlainNameReporter : public benchmark::BenchmarkReporter {
 public:
  explicit PlainNameReporter(std::unique_ptr<benchmark::BenchmarkReporter> reporter)
      : reporter_(std::move(reporter)) {}

  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& report) override;
  void Finalize() override;

 private:
  std::unique_ptr<benchmark::BenchmarkReporter> reporter_;
};

}  // namespace hymm::benchmarks
