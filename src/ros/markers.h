#pragma once

#include <string>

#include <visualization_msgs/MarkerArray.h>

#include "cekf/cekf_slam.h"
#include "cekf/landmark_map.h"

/// What RViz draws of the filter with its standard displays.
namespace hymm {

/// Landmarks as discs of their diameter (0.6 m at least), coloured by type, with their 2-sigma
/// ellipses true to scale, and again ten times as large: of a landmark that was seen often they are
/// centimetres wide, which nobody sees in a picture of the whole map. RViz can switch off each of
/// the two by its namespace.
visualization_msgs::MarkerArray landmarkMarkers(const core::LandmarkMap& map,
                                                const std::string& frame_id);

/// Observations of a scan as rays from the sensor, coloured by what became of them: green updated a
/// landmark, yellow feeds a tentative one, red was rejected.
visualization_msgs::MarkerArray observationMarkers(const core::ScanOutcome& outcome,
                                                   const std::string& frame_id);

}  // namespace hymm
