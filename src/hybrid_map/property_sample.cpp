#include "hybrid_map/property_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include <Eigen/Eigenvalues>

#include "common/gaussian.h"
#include "hybrid_map/input_check.h"

namespace hymm::core {
namespace {

double largestDeviation(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff()));
}

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "'" : ", '") + name + "'";
  return list;
}

}  // namespace

std::optional<std::string> problemWith(const PropertySample& sample, const LayerSet& layers,
                                       double max_deviation_m) {
  const int layer = layers.find(sample.layer);
  if (layer < 0) {
    return "there is no layer '" + sample.layer + "'; there are " + listed(layers.names());
  }
  if (!isPlace(sample.position)) return "the sample's position is not finite, or beyond 10 000 km";
  if (!isSemiDefiniteCovariance(sample.covariance)) {
    return "the covariance of the sample's position is not symmetric positive semi-definite";
  }
  const double deviation = largestDeviation(sample.covariance);
  if (deviation > max_deviation_m) {
    std::ostringstream text;
    text << "the sample's position is uncertain by " << deviation << " m, more than "
         << max_deviation_m << " m";
    return text.str();
  }
  if (const auto problem = layers.model(layer).problemWith(sample.sample)) {
    return "layer '" + sample.layer + "' refuses the sample: " + *problem;
  }
  return std::nullopt;
}

std::vector<Eigen::Vector2d> likelyPlaces(const PropertySample& sample, double resolution_m) {
  if (largestDeviation(sample.covariance) < 0.5 * resolution_m) return {sample.position};
  // Means of the five even shares of a standard normal distribution.
  constexpr std::array<double, 5> kShareMeans = {-1.3998, -0.5319, 0.0, 0.5319, 1.3998};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(sample.covariance);
  const Eigen::Vector2d deviations = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  std::vector<Eigen::Vector2d> places;
  places.reserve(kShareMeans.size() * kShareMeans.size());
  for (const double u : kShareMeans) {
    for (const double v : kShareMeans) {
      const Eigen::Vector2d off =
          axes.eigenvectors() * Eigen::Vector2d(u, v).cwiseProduct(deviations);
      places.emplace_back(sample.position + off);
    }
  }
  return places;
}

}  // namespace hymm::core
