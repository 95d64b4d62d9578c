#!/usr/bin/python3
"""Wiring of the live nodes: bad input is counted, map -> odom has one owner, nodes end in time."""
import json
import math
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from hymm.msg import DeadReckoning, FilterPose
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

BEAMS = 361


def command(node, *arguments):
    return ["rosrun", "hymm", node, *arguments]


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
        while self.motion.get_num_connections() < 2 or self.scans.get_num_connections() < 1:
            time.sleep(0.05)

    def scan(self, frame="laser"):
        message = LaserScan()
        message.header.stamp = rospy.Time.from_sec(self.time_s)
        message.header.frame_id = frame
        message.angle_min = -math.pi / 2
        message.angle_increment = math.pi / (BEAMS - 1)
        message.angle_max = math.pi / 2
        message.range_max = 80.0
        message.ranges = [float("inf")] * BEAMS
        return message

    def drive(self):
        """One step of motion; the scan before it can then be processed."""
        self.time_s += 0.1
        message = DeadReckoning(speed=1.0, steering=0.0)
        message.header.stamp = rospy.Time.from_sec(self.time_s)
        self.motion.publish(message)
        time.sleep(0.05)

    def drive_with(self, scan):
        self.drive()
        scan.header.stamp = rospy.Time.from_sec(self.time_s)
        self.scans.publish(scan)
        self.drive()


class NodesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("nodes_test")
        cls.poses, cls.status, cls.owners = [], {}, set()
        rospy.Subscriber("cekf/pose", FilterPose, cls.poses.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.diagnose)
        rospy.Subscriber("/tf", TFMessage, cls.watch)
        cls.robot = Robot()

    @classmethod
    def diagnose(cls, message):
        for status in message.status:
            cls.status[status.name] = {item.key: item.value for item in status.values}

    @classmethod
    def watch(cls, message):
        for transform in message.transforms:
            if transform.child_frame_id == "odom":
                cls.owners.add(message._connection_header["callerid"])

    def wait_for(self, condition, what):
        deadline = time.time() + 10.0
        while not condition():
            self.assertLess(time.time(), deadline, "waited in vain for " + what)
            time.sleep(0.05)

    def test_all_inf_scan_gives_a_pose(self):
        before = len(self.poses)
        self.robot.drive_with(self.robot.scan())
        self.wait_for(lambda: len(self.poses) > before, "a pose")

    def test_bad_scans_are_counted_and_the_filter_goes_on(self):
        scan = self.robot.scan()
        scan.intensities = [1.0] * (BEAMS - 5)
        self.robot.drive_with(scan)
        self.robot.drive_with(self.robot.scan(frame="nowhere"))
        nan = self.robot.scan()
        nan.ranges = [float("nan")] * BEAMS
        before = len(self.poses)
        self.robot.drive_with(nan)
        # The unknown frame is waited for, 5 s, and then taken from the vehicle's description.
        self.wait_for(lambda: len(self.poses) > before, "a pose after bad scans")
        self.wait_for(lambda: int(self.status.get("cekf_slam: filter", {}).get("scans refused", 0)) >= 1,
                      "a refused scan in /diagnostics")

    def test_map_odom_has_one_owner(self):
        for _ in range(5):
            self.robot.drive_with(self.robot.scan())
        self.wait_for(lambda: self.owners, "map -> odom")
        time.sleep(0.5)
        self.assertEqual(self.owners, {"/supervisor"})

    def test_clock_that_ran_back_begins_a_new_map(self):
        self.robot.drive_with(self.robot.scan())
        self.robot.time_s -= 50.0
        before = len(self.poses)
        for _ in range(5):
            self.robot.drive_with(self.robot.scan())
        self.wait_for(lambda: len(self.poses) >= before + 3, "poses after the jump")
        self.assertLess(self.poses[-1].pose.pose.position.x, 1.5)
        self.wait_for(lambda: int(self.status["cekf_slam: inputs"]["clock resets"]) == 1,
                      "the reset in /diagnostics")

    def test_bad_parameters_are_all_listed(self):
        node = subprocess.run(
            command("cekf_slam", "__name:=bad", "_motion_input:=wheels", "_landmark_rate_hz:=-1"),
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=20, text=True)
        self.assertEqual(node.returncode, 1, node.stdout)
        self.assertIn("motion_input", node.stdout)
        self.assertIn("landmark_rate_hz", node.stdout)

    def test_killed_recorder_leaves_a_complete_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            node = subprocess.Popen(
                command("recorder", "__name:=recorder", "_output:=" + folder,
                        "_save_period_s:=0.2"), preexec_fn=os.setsid)
            self.wait_for(lambda: self.heard_by("recorder"), "the recorder")
            for _ in range(40):  # 4 s by stamps: scans are written 2 s later, in order
                self.robot.drive_with(self.robot.scan())
            time.sleep(0.5)
            os.killpg(node.pid, signal.SIGKILL)
            node.wait()
            summary = json.loads((Path(folder) / "summary.json").read_text())
            trajectory = (Path(folder) / "trajectory.tum").read_text().splitlines()
            self.assertGreater(summary["scans"], 20)
            self.assertEqual(len(trajectory), summary["scans"])
            self.assertIn("had not ended", " ".join(summary["notes"]))
            for name in ("pose_covariance.csv", "health.csv"):
                lines = (Path(folder) / name).read_text().splitlines()
                self.assertEqual(len(lines), summary["scans"] + 1, name)
            self.assertTrue((Path(folder) / "landmarks.csv").read_text().startswith("id,type"))

    @staticmethod
    def heard_by(node):
        subscribers = rosgraph.Master("/nodes_test").getSystemState()[1]
        topics = {topic for topic, nodes in subscribers if "/" + node in nodes}
        return {"/cekf/pose", "/cekf/health", "/landmarks"} <= topics

    def test_nodes_end_within_two_seconds(self):
        for name in ("cekf_slam", "dead_reckoning", "supervisor"):
            node = subprocess.Popen(command(name, "__ns:=/ending", "__name:=" + name),
                                    preexec_fn=os.setsid, stdout=subprocess.DEVNULL,
                                    stderr=subprocess.DEVNULL)
            time.sleep(1.5)
            begin = time.time()
            os.killpg(node.pid, signal.SIGINT)
            self.assertEqual(node.wait(timeout=10), 0, name)
            self.assertLess(time.time() - begin, 2.0, name)


if __name__ == "__main__":
    rostest.rosrun("hymm", "nodes", NodesTest)
