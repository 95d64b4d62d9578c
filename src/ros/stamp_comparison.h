#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace hymm {

/// Whether motion and scans of a recording tell the time by the same clock: from their stamps, and
/// from when they were recorded, which is one clock for both. Keeps a sample of a bounded size.
class StampComparison {
 public:
  enum class Source { kMotion, kScan };

  /// Stamps of zero mean none; they are left out.
  void add(Source source, double stamp_s, double recorded_s);

  /// Sentences about what disagrees; none where nothing does or one source is missing.
  std::vector<std::string> problems() const;

  /// Whether all scans lie before or after all motion, but for a few stray messages.
  bool areApart() const;

 private:
  struct Stamped {
    double stamp_s, recorded_s;
  };
  struct Sample {
    std::vector<Stamped> kept;  ///< every `stride`-th
    std::size_t stride = 1, seen = 0;
  };
  struct Span {
    double begin_s, end_s;
  };

  static double medianAhead(const Sample& sample);
  static Span span(const Sample& sample);

  Sample motion_, scans_;
};

}  // namespace hymm
