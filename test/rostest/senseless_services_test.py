#!/usr/bin/python3
"""Services asked for nonsense, and searches that a reset ends: all answer, no node ends, and with the next
recording all of them work as before."""
import os
import random
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/lib"))
from hostile_suite import NODES, Suite, wait_for  # noqa: E402

BAG = ROOT / "bags/car_park.bag"
PATIENCE_S = 30.0
ROUNDS = 25
ROS_OWN = ("get_loggers", "set_logger_level")


class SenselessServices(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        work = Path(cls.folder.name)
        cls.suite = Suite(Path(os.environ["HYMM_BUILD_DIR"]), work)
        cls.suite.configure(ROOT / "config/datasets/car_park.yaml", use_sim_time="true",
                            recorder__output=work / "recorded")
        cls.suite.start()
        import rospy
        from suite_watcher import Watcher
        rospy.init_node("senseless_services_test", disable_signals=True)
        cls.watcher = Watcher()
        # Diagnostics come when a node has all its services.
        assert wait_for(lambda: all(name in cls.watcher.told for name in NODES), PATIENCE_S)

    @classmethod
    def tearDownClass(cls):
        cls.suite.end()
        cls.folder.cleanup()

    @staticmethod
    def services():
        import rosgraph
        offered = rosgraph.Master("/senseless_services_test").getSystemState()[2]
        return [name for name, nodes in offered
                if not name.endswith(ROS_OWN) and nodes[0].strip("/") in NODES]

    @staticmethod
    def call(name, *arguments, **fields):
        import rospy
        import rosservice
        kind = rosservice.get_service_class_by_name(name)
        return rospy.ServiceProxy(name, kind)(*arguments, **fields)

    def expect_work_with_the_next_recording(self):
        for name in ("/pause", "/hymm_grid/pause"):
            self.assertTrue(self.call(name, pause=False).success)
        for name in ("/reset", "/hymm_grid/reset"):
            self.assertTrue(self.call(name).success)
        self.assertEqual(self.suite.note_crashes(), [])
        player = self.suite.play(BAG)
        self.assertEqual(self.watcher.idle(PATIENCE_S), [])
        self.suite.stop(player)

    def play_until_poses_come(self):
        player = self.suite.play(BAG)
        self.assertEqual(self.watcher.idle(PATIENCE_S), [])
        return player

    def search_where_nothing_is(self):
        """Begins a search that finds nothing, and goes on until it is given up."""
        import rospy
        from geometry_msgs.msg import PoseWithCovarianceStamped
        from hymm.msg import FilterStatus, RelocaliserHealth
        place = PoseWithCovarianceStamped()
        place.header.frame_id = "map"
        place.pose.pose.position.x, place.pose.pose.orientation.w = 500.0, 1.0
        place.pose.covariance[0] = place.pose.covariance[7] = place.pose.covariance[35] = 0.01
        publisher = rospy.Publisher("initialpose", PoseWithCovarianceStamped, queue_size=1)
        heard = []
        readers = [rospy.Subscriber("filter_status", FilterStatus, lambda m: heard.append(m.mode)),
                   rospy.Subscriber("relocaliser/health", RelocaliserHealth, lambda m: heard.append(m.state))]
        wait_for(publisher.get_num_connections, PATIENCE_S)
        publisher.publish(place)
        wait_for(lambda: {FilterStatus.RELOCALISING, RelocaliserHealth.SEARCHING} <= set(heard), PATIENCE_S)
        for reader in readers:
            reader.unregister()

    def test_reset_ends_a_search(self):
        player = self.play_until_poses_come()
        time.sleep(5.0)
        for _ in range(3):
            self.search_where_nothing_is()
            time.sleep(0.5)
            self.assertTrue(self.call("/reset").success)
            self.assertEqual(self.watcher.idle(PATIENCE_S), [])
            time.sleep(2.0)
        self.suite.stop(player)
        self.expect_work_with_the_next_recording()

    def test_another_recording_ends_a_search(self):
        player = self.play_until_poses_come()
        time.sleep(3.0)
        self.search_where_nothing_is()
        self.suite.stop(player)
        self.expect_work_with_the_next_recording()

    def test_relocaliser_that_is_killed_in_its_search(self):
        player = self.play_until_poses_come()
        self.search_where_nothing_is()
        self.suite.kill("relocaliser")
        self.suite.start("relocaliser")
        self.assertEqual(self.watcher.idle(PATIENCE_S), [])
        self.suite.stop(player)
        self.expect_work_with_the_next_recording()

    def test_senseless_requests(self):
        import message_fuzz
        import rospy
        import rosservice
        draw = random.Random(1)
        player = self.play_until_poses_come()
        answered = 0
        for _ in range(ROUNDS):
            for name in self.services():
                kind = rosservice.get_service_class_by_name(name)
                try:
                    self.call(name, message_fuzz.spoiled(kind._request_class(), draw, 2))
                    answered += 1
                except rospy.ServiceException as error:
                    self.fail(f"{name}: {error}")
        self.suite.stop(player)
        self.assertGreaterEqual(answered, 20 * ROUNDS)
        self.expect_work_with_the_next_recording()


if __name__ == "__main__":
    unittest.main(verbosity=2)
