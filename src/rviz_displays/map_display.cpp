#include "rviz_displays/map_display.h"

#include <OgreSceneNode.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>

namespace hymm {

void MapDisplay::followFrame(const std::string& frame) {
  if (frame.empty()) return;
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  const bool known =
      context_->getFrameManager()->getTransform(frame, ros::Time(), position, orientation);
  scene_node_->setVisible(known && isEnabled());
  if (!known) {
    std::string why;
    context_->getFrameManager()->transformHasProblems(frame, ros::Time(), why);
    setStatusStd(Level::Error, "Transform",
                 "The frame '" + frame + "' cannot be placed in '" + fixed_frame_.toStdString() +
                     "': " + why);
    return;
  }
  setStatus(Level::Ok, "Transform", "Transform OK");
  scene_node_->setPosition(position);
  scene_node_->setOrientation(orientation);
}

}  // namespace hymm
