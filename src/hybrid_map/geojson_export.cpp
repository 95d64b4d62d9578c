#include "hybrid_map/geojson_export.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "common/error.h"
#include "common/number_text.h"
#include "common/unfinished_file.h"
#include "hybrid_map/occupied_outlines.h"

namespace hymm::core {
namespace {

std::string jsonNumber(double value) { return std::isfinite(value) ? numberText(value) : "null"; }

std::string positionText(const Eigen::Vector2d& place) {
  return '[' + numberText(place.x()) + ',' + numberText(place.y()) + ']';
}

/// `[element,element,...]`.
template <class Elements, class Text>
std::string arrayText(const Elements& elements, Text&& textOf) {
  std::string text;
  for (const auto& element : elements) text += (text.empty() ? "[" : ",") + textOf(element);
  return text.empty() ? "[]" : text + ']';
}

/// A ring, whose last position repeats the first.
template <class Positions>
std::string ringText(const Positions& positions) {
  std::string text = arrayText(positions, positionText);
  text.back() = ',';
  return text + positionText(positions[0]) + ']';
}

std::string feature(const std::string& type, const std::string& coordinates,
                    const std::string& properties) {
  return R"({"type":"Feature","properties":{)" + properties + R"(},"geometry":{"type":")" + type +
         R"(","coordinates":)" + coordinates + "}}";
}

std::string ltrFeature(const LtrTopology& ltr, const Corners& corners) {
  const std::string ids = arrayText(ltr.landmark_ids, [](int id) { return std::to_string(id); });
  return feature("Polygon", '[' + ringText(corners) + ']',
                 R"("kind":"ltr","id":)" + std::to_string(ltr.id) + R"(,"landmarks":)" + ids +
                     R"(,"observations":)" + jsonNumber(ltr.observations) + R"(,"shape_factor":)" +
                     jsonNumber(ltr.shape_factor));
}

const char* nameOf(LandmarkType type) {
  switch (type) {
    case LandmarkType::kTrunk:
      return "trunk";
    case LandmarkType::kReflector:
      return "reflector";
    default:
      return "unknown";
  }
}

std::string landmarkFeature(const LandmarkEstimate& landmark, const Eigen::Vector2d& place) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(landmark.covariance,
                                                            Eigen::EigenvaluesOnly);
  const double deviation_m = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  return feature("Point", positionText(place),
                 R"("kind":"landmark","id":)" + std::to_string(landmark.id) + R"(,"type":")" +
                     nameOf(landmark.type) + R"(","observations":)" +
                     std::to_string(landmark.observations) + R"(,"diameter_m":)" +
                     jsonNumber(landmark.diameter_m) + R"(,"deviation_m":)" +
                     jsonNumber(deviation_m));
}

std::string occupiedFeature(const OccupancyImage& image) {
  const auto ring = [&](const CellRing& corners) {
    std::vector<Eigen::Vector2d> places;
    places.reserve(corners.size());
    for (const Eigen::Vector2i& corner : corners) {
      places.emplace_back(image.resolution_m * corner.cast<double>());
    }
    return ringText(places);
  };
  const auto polygon = [&](const CellPolygon& cells) {
    std::string text = '[' + ring(cells.outline);
    for (const CellRing& hole : cells.holes) text += ',' + ring(hole);
    return text + ']';
  };
  return feature("MultiPolygon", arrayText(occupiedOutlines(image), polygon),
                 R"("kind":"occupied","resolution_m":)" + jsonNumber(image.resolution_m));
}

}  // namespace

void exportGeoJson(const HybridMap& map, const LandmarkMap& landmarks, const OccupancyImage& image,
                   const std::string& path) {
  std::vector<std::string> features;
  const LtrMesh& mesh = map.partition().mesh();
  for (const LtrTopology& ltr : map.topology(landmarks)) {
    features.push_back(ltrFeature(ltr, mesh.corners(ltr.id)));
  }
  for (const LandmarkEstimate& landmark : landmarks.landmarks) {
    const int vertex = mesh.findVertex(landmark.id);
    features.push_back(landmarkFeature(
        landmark, vertex == kNone ? landmark.position : mesh.vertex(vertex).position));
  }
  if (features.empty() && image.cells.empty()) {
    throw OutputError("'" + path + "' is not written: there are no landmarks and no cells yet.");
  }
  features.push_back(occupiedFeature(image));
  std::string text = R"({"type":"FeatureCollection","frame":"map","unit":"metre","features":)";
  text += arrayText(features, [](const std::string& one) { return '\n' + one; }) + "}\n";
  replaceFile(path, text);
}

}  // namespace hymm::core
