#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hymm::core {

/// One measurement of a property, for one cell.
struct LayerSample {
  double time_s = 0.0;  ///< UTC, since 1970; tells the class of time
  double value = 0.0;   ///< Gaussian: the measured value; rate: number of events; category: weight
  double variance = 0.0;    ///< Gaussian: of the value
  double exposure_s = 0.0;  ///< rate: how long the place was watched
  std::string label;        ///< category: its name; rate: the weather, if the layer tells it apart
};

/// What a layer says about a place.
struct LayerValue {
  /// Occupancy: probability; Gaussian: mean; category: index of the likeliest; rate: events per
  /// hour, over all classes of time.
  double value = 0.0;
  double variance = std::numeric_limits<double>::quiet_NaN();  ///< Gaussian: of the mean
  /// Category: share of each; rate: events per hour in each class of time, NaN where it was never
  /// watched. Empty for other models.
  std::vector<double> parts;
};

/// What the cells of a layer hold and how they learn. A cell is `channels()` floats of evidence,
/// all 0 where nothing is known. Evidence can be divided and added up, so that cells can be moved
/// from one grid to another without losing any; a new kind of layer is a small class of this kind.
class CellModel {
 public:
  virtual ~CellModel() = default;

  virtual int channels() const = 0;

  /// Why a sample cannot be used; nothing if it can.
  virtual std::optional<std::string> problemWith(const LayerSample& sample) const = 0;

  /// Adds `share` (0 to 1) of a usable sample.
  virtual void add(const LayerSample& sample, double share, float* cell) const = 0;

  /// Nothing where nothing is known.
  virtual std::optional<LayerValue> read(const float* cell) const = 0;

  /// Adds `share` (0 to 1) of the evidence of another cell.
  virtual void merge(const float* source, float share, float* cell) const;

  /// Whether cells have limits beyond which they learn no more, and so forget: evidence that came
  /// to a limit is taken to say the same whatever was known before.
  virtual bool hasLimits() const { return false; }
  virtual bool isAtLimit(const float* /*cell*/) const { return false; }

  /// Leaves `share` of a cell's evidence in it.
  virtual void keep(float share, float* cell) const;

  /// Whether the evidence is of some one place in the cell (an obstacle) and not of all of it (free
  /// space). Were that divided between cells, free space around would outweigh each part of it.
  virtual bool isOfOnePlace(const float* /*cell*/) const { return false; }

  /// Amount of evidence, which merge() and keep() divide in the same proportion: a cell from which
  /// a share moved into another, and this other, together have as much as before.
  virtual double evidence(const float* cell) const = 0;
};

/// Log-odds (1) beyond which a cell of the occupancy learns no more.
struct LogOddsLimits {
  float least = -std::numeric_limits<float>::infinity();
  float most = std::numeric_limits<float>::infinity();
};

/// Probability of being occupied in log-odds (1). Beams write it directly; samples are refused.
/// Also the sum of several cells stays within the limits, so that what changes can be relearned.
std::unique_ptr<CellModel> makeOccupancyModel(const LogOddsLimits& limits = {});

/// A value that is the same over the cell, measured with known variance: salinity, humidity, height
/// above the LTR's plane. Where measurements scatter more than they claim, the variance says so.
std::unique_ptr<CellModel> makeGaussianModel();

/// How often each of some kinds was seen: terrain type.
std::unique_ptr<CellModel> makeCategoryModel(const std::vector<std::string>& categories);

/// Events (moving objects) per hour by class of time: `day_parts` equal parts of the day (UTC),
/// times working day or weekend, times weather (none told apart if empty). Classes in this order:
/// index = (weather * 2 + weekend) * day_parts + part.
std::unique_ptr<CellModel> makeRateModel(int day_parts, const std::vector<std::string>& weathers);

}  // namespace hymm::core
