#pragma once

#include <deque>
#include <string>
#include <vector>

#include <hymm/PropertySample.h>
#include <tf2/buffer_core.h>

#include "hybrid_map/property_sample.h"
#include "ros/cause_log.h"

namespace hymm {

/// Brings property samples into the map frame by tf, for which they wait a bounded time.
class SamplePlacer {
 public:
  SamplePlacer(const tf2::BufferCore& tf, const std::string& map_frame, double wait_s,
               CauseLog& causes);

  void add(const PropertySample::ConstPtr& sample, double steady_now_s);

  /// Samples that have a place now, in the order in which they came.
  std::vector<core::PropertySample> takePlaced(double steady_now_s);

  std::size_t waiting() const { return waiting_.size(); }
  void clear() { waiting_.clear(); }

 private:
  struct Waiting {
    PropertySample::ConstPtr sample;
    double since_s;
  };

  const tf2::BufferCore& tf_;
  std::string map_frame_;
  double wait_s_;
  CauseLog& causes_;
  std::deque<Waiting> waiting_;
};

}  // namespace hymm
