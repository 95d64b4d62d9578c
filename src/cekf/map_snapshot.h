#pragma once

#include <vector>

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_map.h"
#include "cekf/landmark_registry.h"

namespace hymm::core {

/// A landmark with its estimate as of now.
LandmarkEstimate estimateOf(const RegisteredLandmark& landmark, const CompressedEkf& filter);

/// All of `landmarks` with what `reader` knows of them, sorted by id, with cross-covariances of
/// pairs within `block_range_m` (0: none). Version, time and merges are left to the caller.
LandmarkMap snapshotOf(std::vector<RegisteredLandmark> landmarks, const EffectReader& reader,
                       double block_range_m);

}  // namespace hymm::core
