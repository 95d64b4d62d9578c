#pragma once

#include <string>

#include <hymm/FilterHealth.h>
#include <hymm/FilterPose.h>

#include "cekf/cekf_slam.h"
#include "pipeline/filter_life.h"

/// What a filter tells after each scan, to messages and back.
namespace hymm {

FilterPose toMessage(const core::PoseEstimate& estimate, const std::string& frame_id);
core::PoseEstimate fromMessage(const FilterPose& message);
core::FilterCounters countersOf(const FilterPose& message);

/// The part of FilterHealth that speaks of one scan; the counts are the node's to fill in.
FilterHealth toMessage(const core::FilterHealth& health, const std::string& frame_id);
core::FilterHealth fromMessage(const FilterHealth& message);

}  // namespace hymm
