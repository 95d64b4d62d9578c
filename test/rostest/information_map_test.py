#!/usr/bin/python3
"""Wiring of the node information_map: level sets follow landmark maps, services answer or say why not."""
import subprocess
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose2D
from hymm.msg import FilterPose, Landmark, LandmarkCovariance, LandmarkMap, LevelSet
from hymm.srv import EvaluateInformation, SuggestExploration
from nav_msgs.msg import OccupancyGrid
from visualization_msgs.msg import MarkerArray

WAIT_S = 60.0  # only a node that is broken needs it


def wait_for(condition):
    end = time.monotonic() + WAIT_S
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


def alley(version, length=60, shift=0.0):
    """Two rows of landmarks along the x axis, all pairs told and uncorrelated."""
    message = LandmarkMap(version=version, block_range=1000.0)
    message.header.frame_id = "map"
    message.header.stamp = rospy.Time.from_sec(100.0 + version)
    places = [(x, y + shift) for x in range(0, length + 1, 5) for y in (-6.0, 6.0)]
    for i, (x, y) in enumerate(places):
        landmark = Landmark(id=i, diameter=0.4, observations=10)
        landmark.position.x, landmark.position.y = x, y
        landmark.covariance = [4e-4, 0.0, 0.0, 4e-4]
        message.landmarks.append(landmark)
        for j in range(i):
            message.cross_covariances.append(
                LandmarkCovariance(first_id=j, second_id=i, covariance=[0.0] * 4))
    return message


class InformationMapTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("information_map_test")
        cls.sets, cls.markers, cls.status = [], [], {}
        rospy.Subscriber("level_sets", LevelSet, cls.sets.append)
        rospy.Subscriber("islands", MarkerArray, cls.markers.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.diagnose)
        cls.maps = rospy.Publisher("landmarks", LandmarkMap, queue_size=10)
        cls.poses = rospy.Publisher("cekf/pose", FilterPose, queue_size=10)
        cls.dense_maps = rospy.Publisher("map", OccupancyGrid, queue_size=10)
        rospy.wait_for_service("evaluate_information", WAIT_S)
        cls.evaluate = rospy.ServiceProxy("evaluate_information", EvaluateInformation)
        cls.suggest = rospy.ServiceProxy("suggest_exploration", SuggestExploration)
        publishers = (cls.maps, cls.poses, cls.dense_maps)
        assert wait_for(lambda: all(publisher.get_num_connections() for publisher in publishers))

    @classmethod
    def diagnose(cls, message):
        for status in message.status:
            cls.status[status.name] = (status.message, {item.key: item.value for item in status.values})

    def send_pose(self, pose):
        """Returns when the node has got it: maps come by another connection, and may overtake it."""
        def count():
            return int(self.status.get("information_map: inputs", ("", {}))[1].get("/cekf/pose messages", 0))

        before = count()
        self.poses.publish(pose)
        self.assertTrue(wait_for(lambda: count() > before))

    def sets_of(self, version):
        return {s.value: s for s in list(self.sets) if s.computed_version == version}

    def test_1_without_a_map_it_says_so(self):
        answer = self.evaluate([Pose2D()], 0)
        self.assertTrue(answer.success)
        self.assertEqual(list(answer.information), [0.0])
        self.assertIn("No pose of the vehicle", self.suggest(0.0).message)
        self.assertTrue(wait_for(lambda: any(
            "No landmark map has been used" in text for text, _ in list(self.status.values()))))

    def test_2_sets_follow_the_map(self):
        self.send_pose(FilterPose())
        self.maps.publish(alley(1))
        self.assertTrue(wait_for(lambda: len(self.sets_of(1)) == 2))
        for level_set in self.sets_of(1).values():
            self.assertTrue(level_set.complete)
            self.assertEqual(level_set.header.frame_id, "map")
            self.assertEqual(len(level_set.islands), 1)
            self.assertEqual(level_set.vehicle_island, level_set.islands[0].id)
            covered = sum(leaf.edge ** 2 for leaf in level_set.leaves)
            self.assertAlmostEqual(covered, level_set.area, places=3)
        self.maps.publish(alley(2, length=100))
        self.assertTrue(wait_for(lambda: len(self.sets_of(2)) == 2))
        self.assertGreater(self.sets_of(2)[25.0].area, self.sets_of(1)[25.0].area)
        self.assertTrue(wait_for(lambda: self.markers and len(self.markers[-1].markers) >= 3))

    def test_3_late_subscribers_get_all_values(self):
        # In a process of its own: within one, all subscribers share a connection.
        heard = subprocess.run(["rostopic", "echo", "-n", "2", "level_sets/value"], timeout=WAIT_S,
                               stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertEqual(heard.split(), ["25.0", "---", "100.0", "---"])

    def test_4_evaluates_poses(self):
        answer = self.evaluate([Pose2D(20.0, 0.0, 0.0), Pose2D(900.0, 0.0, 0.0)], 2)
        self.assertTrue(answer.success, answer.message)
        self.assertGreater(answer.information[0], 100.0)
        self.assertEqual(answer.information[1], 0.0)
        self.assertEqual(len(answer.matrices), 18)
        self.assertEqual(answer.landmarks[1], 0)

    def test_5_says_what_is_wrong_with_a_question(self):
        answer = self.evaluate([Pose2D()], 99)
        self.assertFalse(answer.success)
        self.assertIn("Map version 99 has not arrived", answer.message)
        answer = self.evaluate([Pose2D(float("nan"), 0.0, 0.0)], 0)
        self.assertIn("not finite", answer.message)

    def test_6_suggests_goals(self):
        pose = FilterPose()
        pose.pose.covariance[0] = pose.pose.covariance[7] = 0.01
        pose.pose.covariance[35] = 1e-4
        self.send_pose(pose)
        answer = self.suggest(0.0)
        self.assertTrue(answer.success, answer.message)
        self.assertGreater(answer.goals[0].new_area, 0.0)
        self.assertLess(answer.goals[0].position_deviation, 0.5)
        self.assertIn("know nothing of obstacles", answer.message)
        self.assertGreater(max(goal.goal.x for goal in answer.goals), 20.0)
        self.assertIn("lowest is 25", self.suggest(1.0).message)

    def test_6b_goes_around_what_the_dense_map_tells(self):
        wall = OccupancyGrid()
        wall.header.frame_id = "map"
        wall.info.resolution, wall.info.width, wall.info.height = 0.5, 2, 120
        wall.info.origin.position.x, wall.info.origin.position.y = 15.0, -30.0
        wall.info.origin.orientation.w = 1.0
        wall.data = [100] * 240
        self.dense_maps.publish(wall)
        self.assertTrue(wait_for(lambda: not self.suggest(0.0).message))
        answer = self.suggest(0.0)
        self.assertTrue(answer.success, answer.message)
        self.assertLess(max(goal.goal.x for goal in answer.goals), 15.0)
        wall.data = wall.data[:-1]
        self.dense_maps.publish(wall)
        self.assertTrue(wait_for(lambda: any(
            values.get("dense maps refused") == "1" for _, values in list(self.status.values()))))

    def test_6c_says_that_maps_have_stopped(self):
        pose = FilterPose(map_version=999)
        pose.header.stamp = rospy.Time.from_sec(102.0 + 60.0)  # a minute after the last map
        self.poses.publish(pose)
        self.assertTrue(wait_for(lambda: any(
            "No landmark map has come for 60 s" in text for text, _ in list(self.status.values()))))
        answer = self.evaluate([Pose2D()], 999)
        self.assertIn("Map version 999 has not arrived", answer.message)

    def test_7_begins_anew_with_the_filter(self):
        self.maps.publish(alley(1, length=20, shift=3.0))
        self.assertTrue(wait_for(lambda: self.sets and self.sets[-1].computed_version == 1 and
                                 self.sets[-1].area < self.sets_of(2)[25.0].area))

    def test_8_refuses_another_frame(self):
        message = alley(50)
        message.header.frame_id = "odom"
        self.maps.publish(message)
        self.assertTrue(wait_for(lambda: any(
            values.get("landmarks in another frame") == "1" for _, values in list(self.status.values()))))


if __name__ == "__main__":
    rostest.rosrun("hymm", "information_map_test", InformationMapTest)
