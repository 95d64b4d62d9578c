#!/usr/bin/python3
"""Wiring of the node relocaliser with the filter and the supervisor: it finds the place that an operator asks for, the
filter takes it over, and neither a killed relocaliser nor a killed filter passes in silence."""
import contextlib
import math
import os
import random
import signal
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
import rostest
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped, TransformStamped
from hymm.msg import (DeadReckoning, FilterPose, FilterStatus, LandmarkMap, LandmarkObservation,
                      LandmarkObservations, RelocaliserHealth)
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

LASER_X = 3.78
WHEELBASE = 2.83
SPEED = 4.0
STEERING = 0.14  # a circle of 20 m
STEP_S = 0.1
RANGE = 28.0
REPLAY_S = 3.0  # as relocaliser.test says


def grove(seed=3, count=45, half_width=45.0, separation=5.0):
    """Trees around the circle that the robot drives, none on its way."""
    generator = random.Random(seed)
    trees = []
    radius = WHEELBASE / math.tan(STEERING)
    while len(trees) < count:
        x, y = generator.uniform(-half_width, half_width), generator.uniform(-half_width, half_width)
        on_way = abs(math.hypot(x, y - radius) - radius) < 4.0
        if not on_way and all(math.hypot(x - a, y - b) > separation for a, b in trees):
            trees.append((x, y))
    return trees


def wait_for(condition, what, longest_s=60.0):
    deadline = time.monotonic() + longest_s
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError("waited in vain for " + what)
        time.sleep(0.05)


class Robot:
    """Drives a circle among trees and reports their ranges and bearings, in fog none."""

    def __init__(self):
        self.random = random.Random(1)
        self.trees = grove()
        self.x = self.y = self.yaw = 0.0
        self.time_s = 100.0
        self.fog = False
        self.motion = rospy.Publisher("dead_reckoning", DeadReckoning, queue_size=1000)
        self.detections = rospy.Publisher("detections", LandmarkObservations, queue_size=1000)
        self.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        transform = TransformStamped()
        transform.header.frame_id = "base_link"
        transform.child_frame_id = "laser"
        transform.transform.translation.x = LASER_X
        transform.transform.rotation.w = 1.0
        self.static.publish(TFMessage([transform]))
        wait_for(lambda: self.motion.get_num_connections() >= 3 and self.detections.get_num_connections() >= 1,
                 "those who take motion and detections")

    def step(self):
        self.time_s += STEP_S
        stamp = rospy.Time.from_sec(self.time_s)
        turn = SPEED / WHEELBASE * math.tan(STEERING) * STEP_S
        self.x += SPEED * STEP_S * math.cos(self.yaw + 0.5 * turn)
        self.y += SPEED * STEP_S * math.sin(self.yaw + 0.5 * turn)
        self.yaw += turn
        motion = DeadReckoning(speed=SPEED, steering=STEERING)
        motion.header.stamp = stamp
        self.motion.publish(motion)
        message = LandmarkObservations()
        message.header.stamp = stamp
        message.header.frame_id = "laser"
        laser_x = self.x + LASER_X * math.cos(self.yaw)
        laser_y = self.y + LASER_X * math.sin(self.yaw)
        for x, y in self.trees:
            distance = math.hypot(x - laser_x, y - laser_y)
            bearing = math.remainder(math.atan2(y - laser_y, x - laser_x) - self.yaw, 2 * math.pi)
            if not self.fog and distance < RANGE and abs(bearing) < math.pi / 2:
                message.observations.append(LandmarkObservation(
                    range=distance + self.random.gauss(0.0, 0.05),
                    bearing=bearing + self.random.gauss(0.0, 0.005),
                    covariance=[0.05 ** 2, 0.0, 0.0, 0.005 ** 2], type=LandmarkObservation.TYPE_TRUNK,
                    diameter=float("nan"), diameter_variance=float("nan"), identity=-1))
        self.detections.publish(message)
        time.sleep(0.03)

    def drive(self, steps):
        for _ in range(steps):
            self.step()

    def distance_to(self, pose):
        return math.hypot(pose.position.x - self.x, pose.position.y - self.y)


class RelocaliserTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("relocaliser_test")
        cls.statuses, cls.healths, cls.found, cls.particles = [], [], [], []
        cls.poses, cls.maps = [], []
        rospy.Subscriber("filter_status", FilterStatus, cls.statuses.append)
        rospy.Subscriber("relocaliser/health", RelocaliserHealth, cls.healths.append)
        rospy.Subscriber("relocaliser/pose", PoseWithCovarianceStamped, cls.found.append)
        rospy.Subscriber("relocaliser/particles", PoseArray, cls.particles.append)
        rospy.Subscriber("cekf/pose", FilterPose, cls.poses.append)
        rospy.Subscriber("landmarks", LandmarkMap, cls.maps.append)
        cls.initial = rospy.Publisher("initialpose", PoseWithCovarianceStamped, queue_size=10)
        cls.robot = Robot()
        cls.robot.drive(330)  # once round
        wait_for(lambda: cls.initial.get_num_connections() >= 1, "the relocaliser")

    def drive_until(self, condition, what, longest_s=120.0):
        """Who is in charge is decided by stamps, however slow the machine is: it only takes longer."""
        deadline = time.monotonic() + longest_s
        while time.monotonic() < deadline:
            if condition():
                return
            self.robot.step()
            time.sleep(0.07)  # as fast as it drives: a search has to keep up with scans
        self.fail(f"drove in vain for {what}: {self.statuses[-1].reason!r}; "
                  f"{self.healths[-1].state} {self.healths[-1].reason!r}")

    def expect_found(self, switches_before):
        self.drive_until(lambda: FilterStatus.RELOCALISING in
                         [s.mode for s in self.statuses[switches_before:]], "RELOCALISING")
        self.drive_until(lambda: self.statuses[-1].mode == FilterStatus.CEKF, "the CEKF again")
        self.assertIn("took it over", self.statuses[-1].reason)
        last = self.found[-1]
        self.assertEqual(last.header.frame_id, "map")
        self.drive_until(lambda: self.robot.distance_to(self.poses[-1].pose.pose) < 0.5,
                         "a CEKF that is right")

    def test_1_global_localisation_finds_the_place_and_the_filter_takes_it_over(self):
        before = len(self.statuses)
        rospy.ServiceProxy("global_localization", Empty)()
        self.expect_found(before)
        self.assertTrue(any(health.anywhere for health in self.healths))
        self.assertTrue(self.particles and self.particles[-1].poses)
        self.assertEqual(self.particles[-1].header.frame_id, "map")

    def test_2_initialpose_is_looked_around(self):
        before = len(self.statuses)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x = self.robot.x + 1.0
        message.pose.pose.position.y = self.robot.y - 0.5
        message.pose.pose.orientation.z = math.sin(0.5 * self.robot.yaw)
        message.pose.pose.orientation.w = math.cos(0.5 * self.robot.yaw)
        message.pose.covariance[0] = message.pose.covariance[7] = 1.0
        message.pose.covariance[35] = 0.02
        self.initial.publish(message)
        self.expect_found(before)
        self.assertFalse(self.healths[-1].anywhere)

    def test_3_initialpose_that_cannot_be_is_refused(self):
        before = len(self.statuses)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "nowhere"
        self.initial.publish(message)
        message.header.frame_id = "map"
        message.pose.pose.orientation.w = 1.0
        self.initial.publish(message)  # without covariance
        self.robot.drive(20)
        self.assertEqual(len(self.statuses), before)

    def test_4_killed_relocaliser_is_told_of(self):
        with self.fog():
            rospy.ServiceProxy("global_localization", Empty)()
            self.drive_until(lambda: self.statuses[-1].mode == FilterStatus.RELOCALISING, "RELOCALISING")
            self.kill("relocaliser")
        self.drive_until(lambda: "fell silent" in self.statuses[-1].reason, "the fall back")
        self.assertEqual(self.statuses[-1].mode, FilterStatus.CEKF)

    def test_5_supervisor_started_anew_lets_the_filter_go_on_and_is_obeyed(self):
        with self.fog():
            self.look_anywhere()
            self.drive_until(lambda: self.poses[-1].suspended, "a filter that waits")
            self.kill("supervisor")
        self.drive_until(lambda: any("nobody is on" in s.reason for s in self.statuses), "an end of the waiting")
        self.drive_until(lambda: not self.poses[-1].suspended, "a filter that goes on")
        before = len(self.statuses)
        self.look_anywhere()
        self.expect_found(before)

    def test_6_killed_filter_is_told_of(self):
        known = len(self.maps[-1].landmarks)
        self.assertGreater(known, 10)
        self.kill("cekf_slam")
        self.drive_until(lambda: "is lost" in self.statuses[-1].reason, "what is lost")
        self.assertIn("landmarks", self.statuses[-1].reason)

    @contextlib.contextmanager
    def fog(self):
        """No tree is in sight, nor was when what a search replays was recorded, so that a search cannot end by itself."""
        self.robot.fog = True
        self.robot.drive(math.ceil(REPLAY_S / STEP_S) + 10)
        yield
        self.robot.fog = False

    def look_anywhere(self):
        """By a relocaliser that may have been started anew: it has to know the map first."""
        rospy.wait_for_service("global_localization", 60.0)
        wishes = self.healths[-1].wish
        deadline = time.monotonic() + 60.0
        while self.healths[-1].wish <= wishes:
            self.assertLess(time.monotonic(), deadline, "the relocaliser does not hear the wish")
            rospy.ServiceProxy("global_localization", Empty)()
            self.robot.drive(10)

    @staticmethod
    def process_of(node):
        uri = rosgraph.Master("/relocaliser_test").lookupNode("/" + node)
        return xmlrpc.client.ServerProxy(uri).getPid("/relocaliser_test")[2]

    def kill(self, node):
        os.kill(self.process_of(node), signal.SIGKILL)


if __name__ == "__main__":
    rostest.rosrun("hymm", "relocaliser", RelocaliserTest)
