#pragma once

#include <string>

#include <geometry_msgs/PoseArray.h>
#include <hymm/RelocaliserHealth.h>
#include <nav_msgs/Path.h>

#include "cekf/resumption.h"
#include "relocaliser/relocalisation.h"
#include "supervisor/supervisor_decision.h"

/// What the relocaliser tells, to messages and back.
namespace hymm {

/// The part of RelocaliserHealth that a report tells; the counts are the node's to fill in.
RelocaliserHealth toMessage(const core::SearchReport& report, const std::string& frame_id);

/// What the message says as evidence; its age is the listener's to fill in.
core::RelocaliserEvidence evidenceFrom(const RelocaliserHealth& message);

/// At most `most` of the particles, evenly chosen, in the map frame.
geometry_msgs::PoseArray toMessage(const core::Relocaliser& relocaliser, std::size_t most);

nav_msgs::Path toMessage(const std::vector<core::PlaceAtScan>& path, const std::string& frame_id);
std::vector<core::PlaceAtScan> fromMessage(const nav_msgs::Path& message);

}  // namespace hymm
