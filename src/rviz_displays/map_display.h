#pragma once

#include <string>

#include <rviz/display.h>

namespace hymm {

/// A display of things in the frame of a message's header.
class MapDisplay : public rviz::Display {
 protected:
  using Level = rviz::StatusProperty::Level;

  /// Puts the scene where the frame is now in RViz's fixed frame; where that is not known, nothing
  /// is shown and the status says why.
  void followFrame(const std::string& frame);
};

/// Order in which things over one another are drawn, from below: queues of the renderer.
enum DrawingOrder {
  kDrawLayers = 20,  ///< with RViz's own maps
  kDrawLevelSets = 30,
  kDrawLines = 52,  ///< over what has depth
  kDrawEllipses = 53,
  kDrawDiscs = 54,
  kDrawPlans = 55,
};

/// Heights over the plane of the map [m], so that a view from the side agrees with the order.
constexpr float kLayerHeight_m = 0.0F;
constexpr float kLevelSetHeight_m = 0.02F;
constexpr float kLineHeight_m = 0.04F;
constexpr float kEllipseHeight_m = 0.06F;
constexpr float kDiscHeight_m = 0.08F;
constexpr float kPlanHeight_m = 0.10F;

}  // namespace hymm
