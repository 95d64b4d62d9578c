#include "scene/landmark_shapes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "common/angles.h"
#include "common/gaussian.h"

namespace hymm::core {
namespace {

constexpr int kEllipseCorners = 24, kDiscCorners = 12;
// So many landmarks fill a screen with ellipses of a few pixels, each of which costs its corners in
// every frame.
constexpr std::size_t kMany = 1000;
constexpr int kEllipseCornersOfMany = 10, kDiscCornersOfMany = 6;

/// Triangles that fill a convex border.
void addFilled(const std::vector<Eigen::Vector2d>& border, const Pixel& colour,
               FlatVertices& vertices) {
  for (std::size_t i = 1; i + 1 < border.size(); ++i) {
    vertices.add(border[0], colour);
    vertices.add(border[i], colour);
    vertices.add(border[i + 1], colour);
  }
}

std::vector<Eigen::Vector2d> ellipseOf(const LandmarkEstimate& landmark, const LandmarkStyle& style,
                                       std::size_t landmarks) {
  return ellipseBorder(landmark.position, landmark.covariance, style.magnification * style.sigmas,
                       landmarks > kMany ? kEllipseCornersOfMany : kEllipseCorners);
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
    addFilled(ellipseBorder(landmark.position, Eigen::Matrix2d::Identity(), 0.5 * diameter_m,
                            landmarks.size() > kMany ? kDiscCornersOfMany : kDiscCorners),
              pixelOf(colourOf(landmark.type)), vertices);
  }
  return vertices;
}

FlatVertices filledEllipses(const std::vector<LandmarkEstimate>& landmarks,
                            const LandmarkStyle& style) {
  FlatVertices vertices;
  for (const LandmarkEstimate& landmark : landmarks) {
    Colour colour = colourOf(landmark.type);
    colour.alpha = style.ellipse_alpha;
    addFilled(ellipseOf(landmark, style, landmarks.size()), pixelOf(colour), vertices);
  }
  return vertices;
}

FlatVertices ellipseLines(const std::vector<LandmarkEstimate>& landmarks,
                          const LandmarkStyle& style) {
  FlatVertices vertices;
  for (const LandmarkEstimate& landmark : landmarks) {
    const std::vector<Eigen::Vector2d> border = ellipseOf(landmark, style, landmarks.size());
    const Pixel colour = pixelOf(colourOf(landmark.type));
    for (std::size_t i = 0; i < border.size(); ++i) {
      vertices.add(border[i], colour);
      vertices.add(border[(i + 1) % border.size()], colour);
    }
  }
  return vertices;
}

}  // namespace hymm::core
