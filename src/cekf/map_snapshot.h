#pragma once

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_map.h"
#include "cekf/landmark_registry.h"

namespace hymm::core {

/// A landmark with its estimate as of now.
LandmarkEstimate estimateOf(const RegisteredLandmark& landmark, const CompressedEkf& filter);

/// All landmarks as of now, sorted by id, with cross-covariances of pairs within `block_range_m`.
LandmarkMap snapshotOf(const LandmarkRegistry& registry, const CompressedEkf& filter,
                       double block_range_m);

}  // namespace hymm::core
