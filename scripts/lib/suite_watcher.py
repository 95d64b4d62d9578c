"""What the nodes of the suite say, and what can be said to them."""

import copy
import math
import struct
import time

import rosgraph
import roslib.message
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from hymm.msg import (FilterHealth, FilterPose, GridStatus, LandmarkObservation, LandmarkObservations,
                      LevelSet, RelocaliserHealth)
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2, PointField
from visualization_msgs.msg import MarkerArray

from hostile_suite import NODES, wait_for

# What each node publishes when it has worked on what came in; the recorder tells diagnostics only.
OUTPUTS = {
    "cekf_slam": ("cekf/pose", FilterPose),
    "hymm_grid": ("grid_status", GridStatus),
    "information_map": ("level_sets", LevelSet),
    "door_planner": ("doors", MarkerArray),
    "relocaliser": ("relocaliser/health", RelocaliserHealth),
    "supervisor": ("pose", PoseWithCovarianceStamped),
    "dead_reckoning": ("odom", Odometry),
}


class Watcher:
    """Knows when each node last told its diagnostics, and when it last published a result of new input."""

    def __init__(self):
        self.told, self.worked, self.stamps, self.healths = {}, {}, {}, []
        rospy.Subscriber("/diagnostics", DiagnosticArray, self.hear)
        rospy.Subscriber("cekf/health", FilterHealth, self.healths.append)
        for node, (topic, kind) in OUTPUTS.items():
            rospy.Subscriber(topic, kind, self.take, callback_args=node)

    def hear(self, message):
        for status in message.status:
            self.told[status.name.split(":")[0].strip("/")] = time.monotonic()

    def take(self, message, node):
        stamp = message.header.stamp if hasattr(message, "header") else None
        if stamp is None or self.stamps.get(node) != stamp:
            self.worked[node] = time.monotonic()
        self.stamps[node] = stamp

    def idle(self, patience_s):
        """Nodes that do not tell diagnostics, or publish no new results, while a bag plays."""
        begin = time.monotonic()

        def missing():
            silent = [f"{node} tells no diagnostics" for node in NODES if self.told.get(node, 0.0) <= begin]
            return silent + [f"{node} gives no results" for node in OUTPUTS
                             if self.worked.get(node, 0.0) <= begin]

        wait_for(lambda: not missing(), patience_s)
        return missing()


def inputs_of(node):
    """Topics that a node subscribes to, with the classes of their messages. The clock is the player's."""
    master = rosgraph.Master(rospy.get_name())
    types = dict(master.getTopicTypes())
    topics = [topic for topic, nodes in master.getSystemState()[1] if "/" + node in nodes]
    return {topic: roslib.message.get_message_class(types[topic])
            for topic in topics if topic in types and topic not in ("/clock", "/rosout")}


def samples():
    """Messages in order for inputs that the bag does not hold."""
    seen = [LandmarkObservation(range=8.0, bearing=bearing, covariance=[1e-3, 0.0, 0.0, 1e-5])
            for bearing in (0.4, -0.5, 1.2)]
    fields = [PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1)
              for i, name in enumerate("xyz")]
    places = [(10.0 * math.cos(0.3 * i), 10.0 * math.sin(0.3 * i), 0.5) for i in range(20)]
    cloud = PointCloud2(height=1, width=20, fields=fields, point_step=12, row_step=240,
                        data=b"".join(struct.pack("<fff", *place) for place in places))
    detections = LandmarkObservations(observations=seen)
    for message in (cloud, detections):
        message.header.frame_id = "laser"
    return {"/detections": detections, "/points": cloud}


def stamped(message, stamp):
    """With the present time, so that more than the stamp's age is looked at."""
    if not hasattr(message, "header"):
        return message
    message = copy.copy(message)
    message.header = copy.copy(message.header)
    message.header.stamp = stamp
    return message
