#pragma once

#include <string>

#include "cekf/landmark_map.h"
#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

/// A GeoJSON FeatureCollection (RFC 7946) of the map's geometry, each feature with a property
/// `kind`:
///   ltr       a Polygon, with id, landmarks, observations, and shape_factor (null: not known)
///   landmark  a Point, with id, type, observations, diameter_m (null: not known), and
///             deviation_m, along the longest axis of its covariance
///   occupied  a MultiPolygon, the outlines of the image's occupied cells
/// Coordinates are metres in the frame map, along x and y: a map made without GPS has no place on
/// the globe, so this is what the RFC leaves to "prior arrangement". `landmarks`: the last whole
/// map of them; those that span LTRs are where the LTRs' corners are. Throws OutputError if the
/// file cannot be written, or if there is nothing to write.
void exportGeoJson(const HybridMap& map, const LandmarkMap& landmarks, const OccupancyImage& image,
                   const std::string& path);

}  // namespace hymm::core
