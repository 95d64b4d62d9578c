#include "scene/landmark_shapes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "common/angles.h"
#include "common/gaussian.h"

namespace hymm::core {
namespace {

constexpr int kEllipseCorners = 24;
constexpr int kDiscCorners = 12;

void addFan(const Eigen::Vector2d& middle, const std::vector<Eigen::Vector2d>& border,
            const Colour& colour, FlatVertices& vertices) {
  for (std::size_t i = 0; i < border.size(); ++i) {
    vertices.add(middle, colour);
    vertices.add(border[i], colour);
    vertices.add(border[(i + 1) % border.size()], colour);
  }
}

std::vector<Eigen::Vector2d> ellipseOf(const LandmarkEstimate& landmark,
                                       const LandmarkStyle& style) {
  return ellipseBorder(landmark.position, landmark.covariance, style.magnification * style.sigmas,
                       kEllipseCorners);
}

}  // namespace

std::optional<std::string> problemWith(const std::vector<LandmarkEstimate>& landmarks) {
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const LandmarkEstimate& landmark = landmarks[i];
    const std::string name = "landmark " + std::to_string(landmark.id);
    if (!landmark.position.allFinite()) return name + " has a position that is not finite";
    if (!isSemiDefiniteCovariance(landmark.covariance)) {
      return name + " has a covariance that is not symmetric and positive semi-definite";
    }
    if (i > 0 && landmark.id <= landmarks[i - 1].id) return name + " is out of the order of ids";
  }
  return std::nullopt;
}

std::vector<Eigen::Vector2d> ellipseBorder(const Eigen::Vector2d& position,
                                           const Eigen::Matrix2d& covariance, double sigmas,
                                           int corners) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(covariance);
  Eigen::Matrix2d shape =
      eigen.eigenvectors() * (sigmas * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt()).asDiagonal();
  if (shape.determinant() < 0.0) shape.col(0) = -shape.col(0);  // else it runs clockwise
  std::vector<Eigen::Vector2d> border;
  border.reserve(std::size_t(corners));
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * kPi * i / corners;
    border.emplace_back(position + shape * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return border;
}

FlatVertices landmarkDiscs(const std::vector<LandmarkEstimate>& landmarks,
                           const LandmarkStyle& style) {
  FlatVertices vertices;
  for (const LandmarkEstimate& landmark : landmarks) {
    const double diameter_m = std::isfinite(landmark.diameter_m)
                                  ? std::max(landmark.diameter_m, style.smallest_disc_m)
                                  : style.smallest_disc_m;
    addFan(landmark.position,
           ellipseBorder(landmark.position, Eigen::Matrix2d::Identity(), 0.5 * diameter_m,
                         kDiscCorners),
           colourOf(landmark.type), vertices);
  }
  return vertices;
}

FlatVertices filledEllipses(const std::vector<LandmarkEstimate>& landmarks,
                            const LandmarkStyle& style) {
  FlatVertices vertices;
  for (const LandmarkEstimate& landmark : landmarks) {
    Colour colour = colourOf(landmark.type);
    colour.alpha = style.ellipse_alpha;
    addFan(landmark.position, ellipseOf(landmark, style), colour, vertices);
  }
  return vertices;
}

FlatVertices ellipseLines(const std::vector<LandmarkEstimate>& landmarks,
                          const LandmarkStyle& style) {
  FlatVertices vertices;
  for (const LandmarkEstimate& landmark : landmarks) {
    const std::vector<Eigen::Vector2d> border = ellipseOf(landmark, style);
    for (std::size_t i = 0; i < border.size(); ++i) {
      vertices.add(border[i], colourOf(landmark.type));
      vertices.add(border[(i + 1) % border.size()], colourOf(landmark.type));
    }
  }
  return vertices;
}

}  // namespace hymm::core
