#!/usr/bin/python3
"""Wiring of the live nodes: bad input is counted, map -> odom has one owner, nodes end in time."""
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from hymm.msg import DeadReckoning, FilterPose, LandmarkMap
from hymm.srv import GetJointCovariance, Pause, Reset
from nav_msgs.msg import Path as RosPath
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.dirname(__file__))
from waiting import PATIENCE_S, sends, uri_of, wait_for, wait_for_links  # noqa: E402

BEAMS = 361


def command(node, *arguments):
    return ["rosrun", "hymm", node, *arguments]


def planar(position, rotation):
    return position.x, position.y, 2.0 * math.atan2(rotation.z, rotation.w)


def planar_transform(message):
    return planar(message.transform.translation, message.transform.rotation)


def compose(a, b):
    """Of planar transforms (x, y, yaw)."""
    c, s = math.cos(a[2]), math.sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]


class Robot:
    """Publishes dead reckoning and scans, a tenth of a second apart, with stamps of its own."""

    def __init__(self):
        self.motion = rospy.Publisher("dead_reckoning", DeadReckoning, queue_size=100)
        self.scans = rospy.Publisher("scan", LaserScan, queue_size=100)
        self.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        transform = TransformStamped()
        transform.header.frame_id = "base_link"
        transform.child_frame_id = "laser"
        transform.transform.translation.x = 3.78
        transform.transform.rotation.w = 1.0
        self.static.publish(TFMessage([transform]))
        self.time_s = 100.0
        self.scan_stamp = rospy.Time()  # of the last
        wait_for(lambda: self.is_heard(self.motion, "/cekf_slam", "/dead_reckoning")
                 and self.is_heard(self.scans, "/cekf_slam"), "those who take motion and scans")

    @staticmethod
    def is_heard(publisher, *nodes):
        return set(nodes) <= {connection.endpoint_id for connection in publisher.impl.connections}

    def scan(self, frame="laser", poles=()):
        """Nothing in sight, or poles 0.5 m thick at places (x, y) in the laser's frame."""
        message = LaserScan()
        message.header.stamp = rospy.Time.from_sec(self.time_s)
        message.header.frame_id = frame
        message.angle_min = -math.pi / 2
        message.angle_increment = math.pi / (BEAMS - 1)
        message.angle_max = math.pi / 2
        message.range_max = 80.0
        message.ranges = [float("inf")] * BEAMS
        for x, y in poles:
            self.add_pole(message, x, y)
        return message

    @staticmethod
    def add_pole(message, x, y, radius=0.25):
        for beam in range(BEAMS):
            bearing = message.angle_min + beam * message.angle_increment
            along = x * math.cos(bearing) + y * math.sin(bearing)
            off = abs(y * math.cos(bearing) - x * math.sin(bearing))
            if along > 0.0 and off < radius:
                message.ranges[beam] = along - math.sqrt(radius ** 2 - off ** 2)

    def drive(self):
        """One step of motion; the scan before it can then be processed."""
        self.time_s += 0.1
        message = DeadReckoning(speed=1.0, steering=0.0)
        message.header.stamp = rospy.Time.from_sec(self.time_s)
        self.motion.publish(message)
        time.sleep(0.05)

    def drive_with(self, scan):
        self.drive()
        self.scan_stamp = scan.header.stamp = rospy.Time.from_sec(self.time_s)
        self.scans.publish(scan)
        self.drive()


class NodesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("nodes_test")
        cls.poses, cls.maps, cls.paths = [], [], []
        cls.map_odom, cls.odom_base = [], {}  # (x, y, yaw); (x, y, yaw) by stamp
        cls.status, cls.messages, cls.told, cls.owners = {}, {}, {}, set()
        rospy.Subscriber("landmarks", LandmarkMap, cls.maps.append)
        rospy.Subscriber("trajectory", RosPath, cls.paths.append)
        rospy.Subscriber("cekf/pose", FilterPose, cls.poses.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.diagnose)
        rospy.Subscriber("/tf", TFMessage, cls.watch)
        cls.robot = Robot()
        here = rospy.get_name()
        wait_for_links(("/cekf_slam", here, "/cekf/pose", "/landmarks", "/diagnostics"),
                       ("/cekf_slam", "/supervisor", "/cekf/pose", "/cekf/health"),
                       ("/dead_reckoning", here, "/tf", "/diagnostics"),
                       ("/supervisor", here, "/tf", "/trajectory", "/diagnostics"))

    @classmethod
    def diagnose(cls, message):
        for status in message.status:
            cls.told[status.name] = cls.told.get(status.name, 0) + 1
            cls.messages[status.name] = status.message
            cls.status[status.name] = {item.key: item.value for item in status.values}

    @classmethod
    def watch(cls, message):
        for transform in message.transforms:
            if transform.child_frame_id == "odom":
                cls.owners.add(message._connection_header["callerid"])
                cls.map_odom.append(planar_transform(transform))
            elif transform.child_frame_id == "base_link":
                cls.odom_base[transform.header.stamp] = planar_transform(transform)

    def pose_of(self, scan):
        """Drives with a scan, and waits for its pose: nothing is on its way any more then."""
        self.robot.drive_with(scan)
        stamp = self.robot.scan_stamp
        wait_for(lambda: self.poses and self.poses[-1].header.stamp == stamp, "the scan's pose")
        return self.poses[-1]

    def test_all_inf_scan_gives_a_pose(self):
        self.pose_of(self.robot.scan())

    def test_bad_scans_are_counted_and_the_filter_goes_on(self):
        scan = self.robot.scan()
        scan.angle_increment = 0.0
        self.robot.drive_with(scan)
        self.robot.drive_with(self.robot.scan(frame="nowhere"))
        nan = self.robot.scan()
        nan.ranges = [float("nan")] * BEAMS
        # The unknown frame is waited for, 5 s, and then taken from the vehicle's description.
        self.pose_of(nan)
        wait_for(lambda: int(self.status.get("cekf_slam: filter", {}).get("scans refused", 0)) >= 1,
                      "a refused scan in /diagnostics")

    def count(self, status, key):
        return int(self.status.get(status, {}).get(key, 0))

    def count_now(self, status, key):
        """As it is told after all that has happened so far: the next report may be on its way."""
        before = self.told.get(status, 0)
        wait_for(lambda: self.told.get(status, 0) >= before + 2, "diagnostics of " + status)
        return self.count(status, key)

    def test_late_scans_and_motion_that_is_not_finite_are_counted(self):
        for _ in range(3):
            self.robot.drive_with(self.robot.scan())
        late = self.robot.scan()
        late.header.stamp -= rospy.Duration(0.5)
        self.robot.scans.publish(late)
        nan = DeadReckoning(speed=float("nan"), steering=0.0)
        nan.header.stamp = rospy.Time.from_sec(self.robot.time_s + 0.05)
        self.robot.motion.publish(nan)
        negative = self.robot.scan()
        negative.ranges = [-1.0] * BEAMS
        pose = self.pose_of(negative)
        wait_for(lambda: self.count("cekf_slam: inputs", "out of order") == 1, "'out of order'")
        wait_for(lambda: self.count("cekf_slam: filter", "motion refused") == 1,
                      "refused motion")
        wait_for(lambda: self.count("dead_reckoning: dead reckoning", "refused") >= 1,
                      "refused motion of dead_reckoning")
        wait_for(lambda: self.count("cekf_slam: inputs", "scans with negative ranges") == 1,
                      "negative ranges")
        self.assertTrue(math.isfinite(pose.pose.pose.position.x))

    def test_gap_of_odometry_is_counted_and_makes_uncertain(self):
        variance = self.pose_of(self.robot.scan()).pose.covariance[0]
        gaps = self.count_now("cekf_slam: filter", "motion gaps")
        self.robot.time_s += 5.0
        self.assertGreater(self.pose_of(self.robot.scan()).pose.covariance[0], variance + 1.0)
        wait_for(lambda: self.count("cekf_slam: filter", "motion gaps") == gaps + 1,
                 "the gap in /diagnostics")

    def test_unknown_parameter_is_told_with_the_nearest_name(self):
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log"
            with open(log, "w") as file:
                node = subprocess.Popen(command("supervisor", "__ns:=/unknown", "_tf_rate_hs:=20"),
                                        preexec_fn=os.setsid, stdout=file, stderr=subprocess.STDOUT)
            try:
                wait_for(lambda: "did you mean 'tf_rate_hz'?" in log.read_text(), "the nearest name")
            finally:
                os.killpg(node.pid, signal.SIGKILL)
                node.wait()
            self.assertIn("tf_rate_hs", log.read_text())

    def call(self, name, kind, **request):
        rospy.wait_for_service(name, timeout=PATIENCE_S)
        response = rospy.ServiceProxy(name, kind)(**request)
        self.assertTrue(response.success, response.message)
        self.assertTrue(response.message)

    def expect_map_odom_goes_on(self):
        """In the state in which the nodes are now."""
        before = len(self.map_odom)
        wait_for(lambda: len(self.map_odom) > before + 5, "map -> odom")

    def test_pause_stops_the_filter_but_not_map_odom(self):
        self.pose_of(self.robot.scan())
        wait_for(lambda: self.owners, "map -> odom")
        self.call("pause", Pause, pause=True)
        poses = len(self.poses)
        for _ in range(10):
            self.robot.drive_with(self.robot.scan())
        wait_for(lambda: "Paused" in self.messages.get("cekf_slam: inputs", ""), "'Paused'")
        wait_for(lambda: self.count("cekf_slam: inputs", "paused") >= 20, "20 messages dropped")
        self.expect_map_odom_goes_on()
        self.assertEqual(len(self.poses), poses)
        self.call("pause", Pause, pause=False)
        self.pose_of(self.robot.scan())

    def drive_among_poles(self):
        """From the origin of a new map."""
        self.call("reset", Reset)
        wait_for(lambda: self.maps and not self.maps[-1].landmarks, "an empty map")
        begin_s = self.robot.time_s
        for _ in range(20):
            driven = self.robot.time_s - begin_s  # at 1 m/s
            poles = [(12.0 - driven, 5.0), (15.0 - driven, -6.0), (20.0 - driven, 4.0)]
            self.robot.drive_with(self.robot.scan(poles=poles))
        wait_for(lambda: self.poses and self.maps and self.maps[-1].landmarks, "landmarks")

    def test_joint_covariance_of_landmarks(self):
        self.drive_among_poles()
        rospy.wait_for_service("get_joint_covariance", timeout=PATIENCE_S)
        ask = rospy.ServiceProxy("get_joint_covariance", GetJointCovariance)
        told = {}

        def is_last_map():
            """In the silence after the drive the last map is sent."""
            told["map"] = self.maps[-1]
            told["answer"] = ask(ids=[landmark.id for landmark in reversed(told["map"].landmarks)])
            return told["answer"].version == told["map"].version

        wait_for(is_last_map, "the last map")
        answer, landmarks = told["answer"], told["map"].landmarks
        ids = [landmark.id for landmark in reversed(landmarks)]
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.header.frame_id, "map")
        size = 2 * len(ids)
        self.assertEqual((len(answer.mean), len(answer.covariance)), (size, size * size))
        for i, landmark in enumerate(reversed(landmarks)):
            self.assertAlmostEqual(answer.mean[2 * i], landmark.position.x, places=9)
            self.assertAlmostEqual(answer.covariance[2 * i * size + 2 * i], landmark.covariance[0],
                                   places=12)
        refused = ask(ids=[ids[0], 987654])
        self.assertFalse(refused.success)
        self.assertIn("987654", refused.message)

    def test_reset_begins_a_new_map_where_the_vehicle_stands(self):
        self.drive_among_poles()
        self.assertGreater(self.pose_of(self.robot.scan()).pose.pose.position.x, 1.5)
        version = self.maps[-1].version
        self.call("reset", Reset)
        wait_for(lambda: not self.maps[-1].landmarks, "an empty map")
        self.expect_map_odom_goes_on()
        pose = self.pose_of(self.robot.scan())
        self.assertGreater(self.maps[-1].version, version)
        self.assertLess(abs(pose.pose.pose.position.x), 0.5)
        # The way before the reset was in another map.
        wait_for(lambda: self.paths and len(self.paths[-1].poses) <= 2, "a new trajectory")

    def test_map_odom_carries_the_odometry_to_the_pose(self):
        for _ in range(5):
            self.robot.drive_with(self.robot.scan())

        def fits():
            pose = self.poses[-1]
            odom = self.odom_base.get(pose.header.stamp)
            if not odom or not self.map_odom:
                return False
            expected = planar(pose.pose.pose.position, pose.pose.pose.orientation)
            found = compose(self.map_odom[-1], odom)
            return all(abs(a - b) < 1e-6 for a, b in zip(found, expected))

        wait_for(fits, "map -> odom that fits the pose")

    def test_zz_a_second_owner_of_map_odom_is_named(self):
        other = rospy.Publisher("/tf", TFMessage, queue_size=10)
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "elsewhere", "odom"
        transform.transform.rotation.w = 1.0

        def is_named():
            transform.header.stamp = rospy.Time.now()
            other.publish(TFMessage([transform]))
            return rospy.get_name() + " publishes map -> odom" in self.messages.get(
                "supervisor: supervisor", "")

        wait_for(is_named, "the second owner in /diagnostics")

    def test_map_odom_has_one_owner(self):
        for _ in range(5):
            self.robot.drive_with(self.robot.scan())
        wait_for(lambda: self.owners, "map -> odom")
        time.sleep(0.5)
        self.assertEqual(self.owners, {"/supervisor"})

    def test_clock_that_ran_back_begins_a_new_map(self):
        self.robot.drive_with(self.robot.scan())
        self.robot.time_s -= 50.0
        for _ in range(4):
            self.robot.drive_with(self.robot.scan())
        self.assertLess(self.pose_of(self.robot.scan()).pose.pose.position.x, 1.5)
        wait_for(lambda: self.count("cekf_slam: inputs", "clock resets") == 1,
                 "the reset in /diagnostics")

    def test_bad_parameters_are_all_listed(self):
        node = subprocess.run(
            command("cekf_slam", "__name:=bad", "_motion_input:=wheels", "_landmark_rate_hz:=-1"),
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE_S, text=True)
        self.assertEqual(node.returncode, 1, node.stdout)
        self.assertIn("motion_input", node.stdout)
        self.assertIn("landmark_rate_hz", node.stdout)

    def test_killed_recorder_leaves_a_complete_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            node = subprocess.Popen(
                command("recorder", "__name:=recorder", "_output:=" + folder,
                        "_save_period_s:=0.2"), preexec_fn=os.setsid)
            path = Path(folder) / "summary.json"

            def has_some():
                """Scans are written 2 s later by their stamps, in order."""
                self.robot.drive_with(self.robot.scan())
                return path.exists() and json.loads(path.read_text())["scans"] > 20

            try:
                wait_for(lambda: sends("/cekf_slam", "/recorder", "/cekf/pose", "/cekf/health",
                                       "/landmarks"), "the recorder")
                wait_for(has_some, "20 scans in summary.json")
            finally:
                os.killpg(node.pid, signal.SIGKILL)
                node.wait()
            summary = json.loads(path.read_text())
            trajectory = (Path(folder) / "trajectory.tum").read_text().splitlines()
            self.assertGreater(summary["scans"], 20)
            self.assertEqual(len(trajectory), summary["scans"])
            self.assertIn("had not ended", " ".join(summary["notes"]))
            for name in ("pose_covariance.csv", "health.csv"):
                lines = (Path(folder) / name).read_text().splitlines()
                self.assertEqual(len(lines), summary["scans"] + 1, name)
            self.assertTrue((Path(folder) / "landmarks.csv").read_text().startswith("id,type"))

    def test_nodes_end_by_themselves(self):
        """How fast is measured by scripts/experiments/reliability."""
        for name in ("cekf_slam", "dead_reckoning", "supervisor"):
            node = subprocess.Popen(command(name, "__ns:=/ending", "__name:=" + name),
                                    preexec_fn=os.setsid, stdout=subprocess.DEVNULL,
                                    stderr=subprocess.DEVNULL)
            wait_for(lambda: uri_of("/ending/" + name), name)
            os.killpg(node.pid, signal.SIGINT)
            self.assertEqual(node.wait(timeout=PATIENCE_S), 0, name)


if __name__ == "__main__":
    rostest.rosrun("hymm", "nodes", NodesTest)
