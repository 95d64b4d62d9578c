#include "benchmark/plain_names.h"

#include <regex>

namespace hymm::benchmarks {

bool Registration::matches(const std::string& name) const {
  if (filter_.empty() || filter_ == "all") return true;
  const bool inverted = filter_.front() == '-';
  const std::regex pattern(inverted ? filter_.substr(1) : filter_, std::regex::extended);
  return std::regex_search(name, pattern) != inverted;
}

bool PlainNameReporter::ReportContext(const Context& context) {
  reporter_->SetOutputStream(&GetOutputStream());
  reporter_->SetErrorStream(&GetErrorStream());
  return reporter_->ReportContext(context);
}

void PlainNameReporter::ReportRuns(const std::vector<Run>& report) {
  std::vector<Run> plain = report;
  for (Run& run : plain) {
    const std::string name = run.run_name.function_name;
    run.run_name = {};
    run.run_name.function_name = name;
  }
  reporter_->ReportRuns(plain);
}

void PlainNameReporter::Finalize() { reporter_->Finalize(); }

}  // namespace hymm::benchmarks
