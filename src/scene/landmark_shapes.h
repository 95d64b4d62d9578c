#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "scene/flat_mesh.h"

namespace hymm::core {

/// Why landmarks cannot be drawn; nothing if they can: finite positions, covariances that are
/// symmetric and positive semi-definite, ids that grow.
std::optional<std::string> problemWith(const std::vector<LandmarkEstimate>& landmarks);

/// Corners on the border of the region (x - position)' inv(covariance) (x - position) <= sigmas^2,
/// counter-clockwise. `covariance` is symmetric and positive semi-definite.
std::vector<Eigen::Vector2d> ellipseBorder(const Eigen::Vector2d& position,
                                           const Eigen::Matrix2d& covariance, double sigmas,
                                           int corners);

/// How landmarks are drawn.
struct LandmarkStyle {
  double sigmas = 2.0;
  double magnification = 1.0;    ///< of the ellipses: those of good landmarks are centimetres wide
  double smallest_disc_m = 0.6;  ///< diameter; so that a pole stays visible from above
  float ellipse_alpha = 0.3F;
};

/// Triangles: of each landmark a disc of its diameter, in the colour of its type.
FlatVertices landmarkDiscs(const std::vector<LandmarkEstimate>& landmarks,
                           const LandmarkStyle& style);
/// Triangles that fill the ellipses.
FlatVertices filledEllipses(const std::vector<LandmarkEstimate>& landmarks,
                            const LandmarkStyle& style);
/// Lines around the ellipses.
FlatVertices ellipseLines(const std::vector<LandmarkEstimate>& landmarks,
                          const LandmarkStyle& style);

}  // namespace hymm::core
