#!/usr/bin/python3
"""Wiring of save_map and load_map: one version from both owners, refusals that touch nothing, and
what the other nodes learn."""
import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovariance
from hymm.msg import FilterPose, GridStatus, LandmarkMap, LtrMap
from hymm.srv import LoadMap, Reset, SaveMap

sys.path.insert(0, os.path.dirname(__file__))
from nodes_test import Robot, command  # noqa: E402
from waiting import PATIENCE_S, wait_for, wait_for_links  # noqa: E402

POLES = [(x, y) for x in range(8, 90, 7) for y in (-6.0, 5.0)]
LASER_X = 3.78


class StorageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("storage_test")
        cls.maps, cls.ltrs, cls.states, cls.poses, cls.filter = [], [], [], [], {}
        rospy.Subscriber("cekf/pose", FilterPose, cls.poses.append)
        rospy.Subscriber("landmarks", LandmarkMap, cls.maps.append)
        rospy.Subscriber("ltrs", LtrMap, cls.ltrs.append)
        rospy.Subscriber("grid_status", GridStatus, cls.states.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.diagnose)
        cls.robot = Robot()
        wait_for(lambda: Robot.is_heard(cls.robot.scans, "/cekf_slam", "/hymm_grid"), "those who take scans")
        here = rospy.get_name()
        wait_for_links(("/cekf_slam", "/hymm_grid", "/cekf/pose", "/landmark_updates", "/landmarks"),
                       ("/cekf_slam", here, "/cekf/pose", "/landmarks", "/diagnostics"),
                       ("/hymm_grid", here, "/ltrs", "/grid_status"))
        cls.x = 0.0
        for service in ("save_map", "load_map", "hymm_grid/save_state", "cekf_slam/save_state"):
            rospy.wait_for_service(service, PATIENCE_S)
        cls.save = staticmethod(rospy.ServiceProxy("save_map", SaveMap))
        cls.load = staticmethod(rospy.ServiceProxy("load_map", LoadMap))
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = os.path.join(cls.folder.name, "map")

    @classmethod
    def diagnose(cls, message):
        for status in message.status:
            if status.name == "cekf_slam: filter":
                cls.filter = {item.key: item.value for item in status.values}

    @classmethod
    def drive(cls, scans):
        for _ in range(scans):
            cls.x += 0.1
            laser = cls.x + LASER_X
            near = [(x - laser, y) for x, y in POLES if 0.5 < x - laser < 25.0]
            cls.robot.drive_with(cls.robot.scan(poles=near))
            cls.x += 0.1

    def scans_at(self, version):
        """Written by the dense map up to this version of the landmarks."""
        wait_for(lambda: self.states[-1].landmark_version >= version, "the dense map")
        return self.states[-1].scans

    def test_1_saves_one_version_of_both(self):
        self.drive(60)
        wait_for(lambda: self.ltrs and self.ltrs[-1].ltrs, "LTRs")
        answer = self.save(path=self.path)
        self.assertTrue(answer.success, answer.message)
        self.assertGreater(answer.landmarks, 5)
        self.assertGreater(answer.ltrs, 2)
        told = Path(self.path, "map.txt").read_text()
        self.assertIn(f"landmark_version {answer.landmark_version}\n", told)
        type(self).saved = answer

    def test_2_saves_while_scans_come_and_loses_none(self):
        before = self.states[-1].lost_scans
        for _ in range(5):
            self.drive(4)
            answer = self.save(path=self.path)
            self.assertTrue(answer.success, answer.message)
        self.drive(10)
        self.scans_at(answer.landmark_version)
        self.assertEqual(self.states[-1].lost_scans, before)
        self.assertEqual(len(os.listdir(self.path)), 3, "what is not the map any more is removed")
        type(self).saved = answer

    def test_3_refuses_what_it_cannot_use_and_goes_on(self):
        self.assertIn("absolute", self.save(path="map").message)
        self.assertIn("exists", self.save(path="/no/such/place").message)
        self.assertIn("absolute", self.load(path="").message)
        self.assertIn("no saved map", self.load(path=self.folder.name).message)
        for file in os.listdir(self.path):
            place = Path(self.path, file)
            content = place.read_bytes()
            place.write_bytes(content[:-7] + b"x" + content[-6:])
            answer = self.load(path=self.path)
            self.assertFalse(answer.success)
            self.assertIn("damaged", answer.message)
            place.write_bytes(content)
        version = self.maps[-1].version
        self.drive(10)
        wait_for(lambda: self.maps[-1].version > version, "the map going on")
        wait_for(lambda: self.filter, "diagnostics")
        self.assertEqual(self.filter["resets"], "0", "a refusal touches nothing")

    def test_4_a_loaded_map_takes_the_place_of_the_present_one(self):
        type(self).saved = self.save(path=self.path)
        self.assertTrue(self.saved.success, self.saved.message)
        rospy.ServiceProxy("reset", Reset)()
        rospy.ServiceProxy("hymm_grid/reset", Reset)()
        wait_for(lambda: not self.maps[-1].landmarks, "an empty map")
        answer = self.load(path=self.path)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.landmarks, self.saved.landmarks)
        self.assertEqual(answer.ltrs, self.saved.ltrs)
        self.assertEqual(answer.differences, [])
        wait_for(lambda: len(self.maps[-1].landmarks) == self.saved.landmarks, "its landmarks")
        wait_for(lambda: len(self.ltrs[-1].ltrs) == self.saved.ltrs, "its LTRs")
        scans = self.states[-1].scans
        self.drive(20)
        wait_for(lambda: self.states[-1].scans >= scans + 10, "scans written into the loaded map")
        self.assertGreaterEqual(len(self.ltrs[-1].ltrs), self.saved.ltrs)

    def test_5_localising_leaves_the_map_as_it_is(self):
        pose = PoseWithCovariance()
        pose.pose.position.x, pose.pose.orientation.w = self.x, 1.0
        pose.covariance[0] = pose.covariance[7] = 0.04
        pose.covariance[35] = 0.0025
        answer = self.load(path=self.path, localise_only=True, use_pose=True, pose=pose)
        self.assertTrue(answer.success, answer.message)
        wait_for(lambda: len(self.maps[-1].landmarks) == self.saved.landmarks, "its landmarks")
        places = {m.id: (m.position.x, m.position.y) for m in self.maps[-1].landmarks}
        self.drive(10)
        scans = self.scans_at(answer.landmark_version + 5)
        self.drive(20)
        self.assertEqual(self.scans_at(answer.landmark_version + 15), scans)
        wait_for(lambda: self.maps[-1].version > answer.landmark_version + 5, "a later map")
        self.assertEqual({m.id: (m.position.x, m.position.y) for m in self.maps[-1].landmarks}, places)
        wait_for(lambda: self.poses[-1].header.stamp == self.robot.scan_stamp, "the last scan's pose")
        position = self.poses[-1].pose.pose.position
        scan_x = self.x - 0.1  # the rest was driven since
        for x, y in [(x, y) for x, y in POLES if 4.0 < x - scan_x < 12.0]:
            seen = position.x + x - scan_x, position.y + y
            self.assertLess(min(math.dist(seen, place) for place in places.values()), 0.3, "among the map's landmarks")

    def test_6_a_map_to_begin_with_that_cannot_be_loaded_ends_the_node_with_a_failure(self):
        rospy.set_param("/failing/saved_map/folder", os.path.join(self.folder.name, "nowhere"))
        node = subprocess.run(command("supervisor", "__ns:=/failing", "__name:=supervisor"), timeout=PATIENCE_S,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertEqual(node.returncode, 1, node.stdout)
        self.assertIn("cannot be loaded", node.stdout)


if __name__ == "__main__":
    rostest.rosrun("hymm", "storage", StorageTest)
