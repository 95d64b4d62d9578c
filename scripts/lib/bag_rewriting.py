"""Rewrites simulated bags as other drivers would have recorded them."""

import math

import genpy
import numpy as np
import rosbag
from sensor_msgs.msg import PointCloud2, PointField

OPEN_SPACE = {"zero": 0.0, "nan": math.nan, "range_max": None}


def rewrite(source, target, change):
    """Writes to `target` what `change(topic, message)` makes of each message: (topic, message) or None."""
    with rosbag.Bag(str(source)) as bag, rosbag.Bag(str(target), "w") as out:
        for topic, message, time in bag.read_messages():
            changed = change(topic, message)
            if changed:
                out.write(changed[0], changed[1], time)


def _on(wanted, edit):
    def change(topic, message):
        if topic == wanted:
            edit(message)
        return topic, message
    return change


def no_return_as(value):
    """`value`: a key of OPEN_SPACE, or a number of metres beyond range_max."""
    def edit(scan):
        told = OPEN_SPACE[value] if value in OPEN_SPACE else scan.range_max + value
        told = scan.range_max if told is None else told
        scan.ranges = [told if math.isinf(r) else r for r in scan.ranges]
    return _on("/scan", edit)


def _turn_around(scan):
    scan.ranges = scan.ranges[::-1]
    scan.intensities = scan.intensities[::-1]


def clockwise():
    def edit(scan):
        _turn_around(scan)
        scan.angle_min, scan.angle_max = scan.angle_max, scan.angle_min
        scan.angle_increment = -scan.angle_increment
    return _on("/scan", edit)


def upside_down():
    """The laser hangs: tf says so by half a turn of roll."""
    def change(topic, message):
        if topic == "/scan":
            _turn_around(message)
            message.angle_min, message.angle_max = -message.angle_max, -message.angle_min
        for transform in message.transforms if topic == "/tf_static" else []:
            if transform.child_frame_id == "laser":
                q = transform.transform.rotation
                q.x, q.y, q.z, q.w = q.w, q.z, -q.y, -q.x  # turned by (1, 0, 0, 0) on the right
        return topic, message
    return change


def from_zero_to_a_turn():
    def edit(scan):
        half = len(scan.ranges) // 2
        scan.ranges = scan.ranges[half:] + scan.ranges[:half]
        scan.intensities = []
        scan.angle_min, scan.angle_max = 0.0, 2.0 * math.pi - scan.angle_increment
    return _on("/scan", edit)


def late(delay_s, jitter_s=0.0, seed=1):
    generator = np.random.default_rng(seed)

    def edit(scan):
        delay = delay_s + (abs(generator.normal(0.0, jitter_s)) if jitter_s else 0.0)
        scan.header.stamp = scan.header.stamp + genpy.Duration.from_sec(delay)
    return _on("/scan", edit)


def every(n, topics=("/odom", "/tf")):
    counts = dict.fromkeys(topics, 0)

    def change(topic, message):
        if topic in counts:
            counts[topic] += 1
            if counts[topic] % n:
                return None
        return topic, message
    return change


def odometry_of_poses():
    def edit(odometry):
        twist = odometry.twist.twist
        twist.linear.x = twist.linear.y = twist.angular.z = 0.0
    return _on("/odom", edit)


def odometry_in_utm():
    def edit(odometry):
        odometry.pose.pose.position.x += 334000.0
        odometry.pose.pose.position.y += 6251000.0
    return _on("/odom", edit)


def with_names_of_another_robot():
    frames = {"base_link": "/robot/base_footprint", "odom": "/robot/odom", "laser": "/front_laser"}
    topics = {"/scan": "/front/scan", "/odom": "/wheel/odom"}

    def change(topic, message):
        for transform in message.transforms if topic in ("/tf", "/tf_static") else []:
            header = transform.header
            header.frame_id = frames.get(header.frame_id, header.frame_id)
            transform.child_frame_id = frames.get(transform.child_frame_id, transform.child_frame_id)
        if topic in topics:
            message.header.frame_id = frames[message.header.frame_id]
        return topics.get(topic, topic), message
    return change


def fixes_without_covariance():
    def edit(fix):
        fix.position_covariance_type = 0
        fix.position_covariance = [0.0] * 9
    return _on("/gps/fix", edit)


def _cloud_of(scan, kind):
    ranges = np.array(scan.ranges)
    angles = scan.angle_min + np.arange(len(ranges)) * scan.angle_increment
    hit = np.isfinite(ranges)
    xyz = np.stack([ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))], 1)
    if kind == "organised":
        xyz[~hit] = math.nan
    else:
        xyz = xyz[hit]
    order = ">" if kind == "big_endian" else "<"
    number, size, code = ("f8", 8, 8) if kind == "doubles" else ("f4", 4, 7)
    columns = 8 if kind in ("plain", "organised") else 3  # of 32 bytes, as PCL pads its points
    points = np.zeros((len(xyz), columns), order + number)
    points[:, :3] = xyz
    cloud = PointCloud2(header=scan.header, height=1, width=len(xyz), point_step=columns * size)
    cloud.fields = [PointField(name, i * size, code, 1) for i, name in enumerate("xyz")]
    cloud.is_bigendian = order == ">"
    cloud.data = points.tobytes() + (b"\0" * 20 if kind == "padded_rows" else b"")
    cloud.row_step = len(cloud.data)
    return cloud


def clouds(kind):
    """One ring of a 3D sensor, 0.8 m above the ground; `kind`: plain, organised (NaN where nothing
    is), doubles, big_endian or padded_rows."""
    def change(topic, message):
        for transform in message.transforms if topic == "/tf_static" else []:
            transform.transform.translation.z = 0.8
        if topic == "/scan":
            return "/points", _cloud_of(message, kind)
        return topic, message
    return change
