#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"

namespace hymm::core {

/// The rigid motion of the plane that brings the most of `estimates` within `tolerance_m` of
/// landmarks of `truth`, found from their pattern alone: each of a bounded number of pairs of
/// estimates is laid over every pair of true ones that is about as long. Nothing where fewer than
/// five fit, or fewer than half of the shorter list: then chance may do as well. Where rows are
/// alike, several motions fit about as well.
std::optional<Pose2> findConstellation(const std::vector<Eigen::Vector2d>& estimates,
                                       const std::vector<Eigen::Vector2d>& truth,
                                       double tolerance_m);

}  // namespace hymm::core
