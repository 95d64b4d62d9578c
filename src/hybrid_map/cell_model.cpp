#include "hybrid_map/cell_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hybrid_map/log_odds.h"

namespace hymm::core {

void CellModel::merge(const float* source, float share, float* cell) const {
  for (int i = 0; i < channels(); ++i) cell[i] += share * source[i];
}

void CellModel::keep(float share, float* cell) const {
  for (int i = 0; i < channels(); ++i) cell[i] *= share;
}

namespace {

int placeOf(const std::string& name, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "'" : ", '") + name + "'";
  return list;
}

// Cells hold floats. Within these bounds no sum of evidence leaves their range, however many
// samples come: a float no longer grows once 2^24 equal parts were added.
constexpr double kMostEvidence = 1e15;
constexpr double kLeastEvidence = 1e-15;
constexpr double kLargestValue = 1e15;
constexpr double kLargestVariance = 1e30;
constexpr double kLeastVariance = 1e-30;
// Beyond some 30 000 years a double does not tell the time of day.
constexpr double kLatest_s = 1e12;

bool isEvidence(double amount) { return amount >= kLeastEvidence && amount <= kMostEvidence; }

class OccupancyModel : public CellModel {
 public:
  explicit OccupancyModel(const LogOddsLimits& limits) : limits_(limits) {}

  int channels() const override { return 1; }
  std::optional<std::string> problemWith(const LayerSample& sample) const override {
    static_cast<void>(sample);
    return "occupancy is learned from beams; it takes no samples";
  }
  void add(const LayerSample& /*sample*/, double /*share*/, float* /*cell*/) const override {}
  std::optional<LayerValue> read(const float* cell) const override {
    if (cell[0] == 0.0F) return std::nullopt;
    LayerValue value;
    value.value = probabilityOf(static_cast<double>(cell[0]));
    return value;
  }
  void merge(const float* source, float share, float* cell) const override {
    cell[0] = std::clamp(cell[0] + share * source[0], limits_.least, limits_.most);
  }
  bool hasLimits() const override { return true; }
  bool isAtLimit(const float* cell) const override {
    return cell[0] <= limits_.least || cell[0] >= limits_.most;
  }
  bool isOfOnePlace(const float* cell) const override { return cell[0] > 0.0F; }
  double evidence(const float* cell) const override { return static_cast<double>(cell[0]); }

 private:
  LogOddsLimits limits_;
};

class GaussianModel : public CellModel {
 public:
  int channels() const override { return 4; }
  std::optional<std::string> problemWith(const LayerSample& sample) const override {
    if (!std::isfinite(sample.value)) return "its value is not finite";
    if (std::abs(sample.value) > kLargestValue) {
      return "its value is beyond 1e15 or -1e15, which a cell cannot hold";
    }
    if (!std::isfinite(sample.variance) || sample.variance <= 0.0) {
      return "the variance of its value is not positive";
    }
    if (sample.variance < kLeastVariance || sample.variance > kLargestVariance) {
      return "the variance of its value is not within 1e-30 and 1e30, which a cell can hold";
    }
    return std::nullopt;
  }
  void add(const LayerSample& sample, double share, float* cell) const override {
    // A value is no more certain than the float that holds it.
    constexpr double kRounding = 0.5 * static_cast<double>(std::numeric_limits<float>::epsilon());
    const double deviation = kRounding * sample.value;
    const double variance = std::max(sample.variance, deviation * deviation);
    const float one[] = {static_cast<float>(1.0 / variance), static_cast<float>(sample.value), 0.0F,
                         1.0F};
    merge(one, static_cast<float>(share), cell);
  }
  std::optional<LayerValue> read(const float* cell) const override {
    if (cell[kWeight] <= 0.0F) return std::nullopt;
    const double n = static_cast<double>(cell[kCount]);
    const double scatter = n > 1.0 ? static_cast<double>(cell[kScatter]) / (n - 1.0) : 0.0;
    LayerValue value;
    value.value = static_cast<double>(cell[kMean]);
    value.variance = std::max(1.0, scatter) / static_cast<double>(cell[kWeight]);
    return value;
  }
  // Means and sums of squares about them are joined without cancellation.
  void merge(const float* source, float share, float* cell) const override {
    const float weight = share * source[kWeight];
    if (weight <= 0.0F) return;
    const float sum = cell[kWeight] + weight;
    // In floats, the products could leave the range that what they come to does not leave.
    const double difference = static_cast<double>(source[kMean]) - static_cast<double>(cell[kMean]);
    const double part = static_cast<double>(weight) / static_cast<double>(sum);
    const double between = difference * difference * static_cast<double>(cell[kWeight]) * part;
    cell[kScatter] += share * source[kScatter] + static_cast<float>(between);
    cell[kMean] += static_cast<float>(difference * part);
    cell[kWeight] = sum;
    cell[kCount] += share * source[kCount];
  }
  void keep(float share, float* cell) const override {
    cell[kWeight] *= share;
    cell[kScatter] *= share;
    cell[kCount] *= share;
    if (share <= 0.0F) cell[kMean] = 0.0F;
  }
  double evidence(const float* cell) const override { return static_cast<double>(cell[kCount]); }

 private:
  enum Channel { kWeight, kMean, kScatter, kCount };
};

class CategoryModel : public CellModel {
 public:
  explicit CategoryModel(std::vector<std::string> categories)
      : categories_(std::move(categories)) {}

  int channels() const override { return static_cast<int>(categories_.size()); }
  std::optional<std::string> problemWith(const LayerSample& sample) const override {
    if (!std::isfinite(sample.value) || sample.value <= 0.0) return "its weight is not positive";
    if (!isEvidence(sample.value)) {
      return "its weight is not within 1e-15 and 1e15, which a cell can hold";
    }
    if (placeOf(sample.label, categories_) < 0) {
      return "it has no category '" + sample.label + "'; there are " + listed(categories_);
    }
    return std::nullopt;
  }
  void add(const LayerSample& sample, double share, float* cell) const override {
    cell[placeOf(sample.label, categories_)] += static_cast<float>(share * sample.value);
  }
  std::optional<LayerValue> read(const float* cell) const override {
    const double sum = evidence(cell);
    if (sum <= 0.0) return std::nullopt;
    LayerValue value;
    value.value = static_cast<double>(std::max_element(cell, cell + channels()) - cell);
    for (int i = 0; i < channels(); ++i) value.parts.push_back(static_cast<double>(cell[i]) / sum);
    return value;
  }
  double evidence(const float* cell) const override {
    double sum = 0.0;
    for (int i = 0; i < channels(); ++i) sum += static_cast<double>(cell[i]);
    return sum;
  }

 private:
  std::vector<std::string> categories_;
};

class RateModel : public CellModel {
 public:
  RateModel(int day_parts, std::vector<std::string> weathers)
      : day_parts_(day_parts), weathers_(std::move(weathers)) {}

  int channels() const override { return 2 * classes(); }
  std::optional<std::string> problemWith(const LayerSample& sample) const override {
    if (!std::isfinite(sample.time_s)) return "its time is not finite";
    if (std::abs(sample.time_s) > kLatest_s) {
      return "its time is not within 1e12 s of 1970, so that it has no time of day";
    }
    if (!std::isfinite(sample.value) || sample.value < 0.0)
      return "its number of events is negative";
    if (sample.value > 0.0 && !isEvidence(sample.value)) {
      return "its number of events is not within 1e-15 and 1e15, which a cell can hold";
    }
    if (!std::isfinite(sample.exposure_s) || sample.exposure_s <= 0.0) {
      return "the time for which the place was watched is not positive";
    }
    if (!isEvidence(sample.exposure_s)) {
      return "the time for which the place was watched is not within 1e-15 and 1e15 s, which a "
             "cell can hold";
    }
    if (!weathers_.empty() && placeOf(sample.label, weathers_) < 0) {
      return "it knows no weather '" + sample.label + "'; there are " + listed(weathers_);
    }
    return std::nullopt;
  }
  void add(const LayerSample& sample, double share, float* cell) const override {
    float* part = cell + 2 * classOf(sample);
    part[0] += static_cast<float>(share * sample.value);
    part[1] += static_cast<float>(share * sample.exposure_s / 3600.0);
  }
  std::optional<LayerValue> read(const float* cell) const override {
    double events = 0.0, hours = 0.0;
    LayerValue value;
    for (int i = 0; i < classes(); ++i) {
      const double in_class = static_cast<double>(cell[2 * i]);
      const double watched = static_cast<double>(cell[2 * i + 1]);
      value.parts.push_back(watched > 0.0 ? in_class / watched
                                          : std::numeric_limits<double>::quiet_NaN());
      events += in_class;
      hours += watched;
    }
    if (hours <= 0.0) return std::nullopt;
    value.value = events / hours;
    return value;
  }
  double evidence(const float* cell) const override {
    double hours = 0.0;
    for (int i = 0; i < classes(); ++i) hours += static_cast<double>(cell[2 * i + 1]);
    return hours;
  }

 private:
  int classes() const { return day_parts_ * 2 * std::max(1, static_cast<int>(weathers_.size())); }
  int classOf(const LayerSample& sample) const {
    constexpr double kDay_s = 86400.0;
    const double day = std::floor(sample.time_s / kDay_s);
    const double of_day = (sample.time_s - day * kDay_s) / kDay_s;
    const int part = std::min(day_parts_ - 1, static_cast<int>(of_day * day_parts_));
    // Day 0, 1 January 1970, was a Thursday: days 2 and 3 of each seven are a weekend.
    const double of_week = day - 7.0 * std::floor(day / 7.0);
    const int weekend = of_week == 2.0 || of_week == 3.0 ? 1 : 0;
    const int weather = std::max(0, placeOf(sample.label, weathers_));
    return (weather * 2 + weekend) * day_parts_ + part;
  }

  int day_parts_;
  std::vector<std::string> weathers_;
};

}  // namespace

std::unique_ptr<CellModel> makeOccupancyModel(const LogOddsLimits& limits) {
  return std::make_unique<OccupancyModel>(limits);
}
std::unique_ptr<CellModel> makeGaussianModel() { return std::make_unique<GaussianModel>(); }
std::unique_ptr<CellModel> makeCategoryModel(const std::vector<std::string>& categories) {
  return std::make_unique<CategoryModel>(categories);
}
std::unique_ptr<CellModel> makeRateModel(int day_parts, const std::vector<std::string>& weathers) {
  return std::make_unique<RateModel>(day_parts, weathers);
}

}  // namespace hymm::core
