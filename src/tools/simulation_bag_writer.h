#pragma once

#include <rosbag/bag.h>

#include "simulation/simulation.h"
#include "tools/vehicle_bag.h"

namespace hymm {

/// Writes a simulation to a bag as a robot's drivers would have published it: /scan, /detections,
/// /dead_reckoning, /odom and /tf, /gps/fix, and latched /tf_static and /gps/origin; and the truth:
/// /truth/pose for each scan or detection, latched /truth/landmarks and /truth/map. Worlds with
/// hills add /property_samples of the height; what is true there is so in space. A message's bag
/// time is its stamp.
class SimulationBagWriter {
 public:
  /// `terrain`: of the world, in map.
  SimulationBagWriter(rosbag::Bag& bag, const core::SimulationConfig& config,
                      const core::VehicleConfig& vehicle, const core::Terrain& terrain);

  /// What holds for the whole recording, before the first event.
  void writeMountings(double time_s) { vehicle_bag_.writeMountings(time_s); }
  void writeGpsOrigin(double time_s) { vehicle_bag_.writeGpsOrigin(time_s); }
  void writeLandmarks(const std::vector<core::TrueLandmark>& landmarks, double time_s);
  void writeOccupancy(const core::TrueOccupancy& occupancy, double time_s);

  void write(const core::SimulatedEvent& simulated);

 private:
  void write(const core::MotionInput& input);
  void write(const core::ScanEvent& event);
  void write(const core::ObservationSet& set);
  void write(const core::GpsFix& fix);
  void write(const core::ClockReset&) {}  // a simulated clock never runs back
  void writePose(const core::Pose2& T_map_base, double time_s);
  void writeHeight(double height_m, double time_s);

  rosbag::Bag& bag_;
  core::VehicleConfig vehicle_;
  core::SimulatedAltimeterConfig altimeter_;
  core::Terrain terrain_;
  VehicleBag vehicle_bag_;
};

}  // namespace hymm
