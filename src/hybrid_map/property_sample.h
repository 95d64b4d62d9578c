#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/layer_set.h"

namespace hymm::core {

/// A measured property at a place.
struct PropertySample {
  std::string layer;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();    ///< in map, m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the position, m^2
  LayerSample sample;
};

/// Why a sample cannot be written; nothing if it can.
std::optional<std::string> problemWith(const PropertySample& sample, const LayerSet& layers,
                                       double max_deviation_m);

/// Equally likely places of a sample: one if its place is certain to half a cell, else the means of
/// even shares of a normal distribution along both axes of its covariance.
std::vector<Eigen::Vector2d> likelyPlaces(const PropertySample& sample, double resolution_m);

}  // namespace hymm::core
