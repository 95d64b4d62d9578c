#!/usr/bin/python3
"""Who is in charge, by what the filters say: the switches, their reasons, and one map -> odom that never stops."""
import threading
import time
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from hymm.msg import FilterHealth, FilterPose, FilterStatus, RelocaliserHealth
from hymm.srv import Resume, ResumeRequest, ResumeResponse, SetMode
from tf2_msgs.msg import TFMessage

BAD_NIS = 60.0  # of 4 degrees of freedom
SCAN_S = 0.2
PATIENCE_S = 60.0  # only a node that is broken needs it
SUSPICIOUS_SCANS = 10  # as long as switching/suspicious_s


class Filters:
    """The CEKF and the relocaliser, as far as the supervisor hears of them."""

    def __init__(self):
        self.time_s = 100.0
        self.scans = 0
        self.order = 0
        self.state = RelocaliserHealth.IDLE
        self.wish = 0
        self.particles = 0
        self.is_alive = True
        self.resumed = []
        self.pose = rospy.Publisher("cekf/pose", FilterPose, queue_size=1000)
        self.health = rospy.Publisher("cekf/health", FilterHealth, queue_size=1000)
        self.search = rospy.Publisher("relocaliser/health", RelocaliserHealth, queue_size=1000)
        self.found = rospy.Publisher("relocaliser/pose", PoseWithCovarianceStamped, queue_size=1000)
        self.tf = rospy.Publisher("/tf", TFMessage, queue_size=1000)
        rospy.Service("resume", Resume, self.resume)
        rospy.Subscriber("filter_status", FilterStatus, self.obey)
        publishers = (self.pose, self.health, self.search, self.found, self.tf)
        deadline = time.monotonic() + 60.0
        while any(publisher.get_num_connections() < 1 for publisher in publishers):
            if time.monotonic() > deadline:
                raise TimeoutError("nobody listens to the filters")
            time.sleep(0.05)
        threading.Thread(target=self.beat, daemon=True).start()

    def resume(self, request):
        self.resumed.append(request)
        return ResumeResponse(success=True, message="done")

    def obey(self, status):
        if status.mode == FilterStatus.RELOCALISING and status.order != self.order:
            self.order = status.order
            self.state = RelocaliserHealth.SEARCHING

    def beat(self):
        while not rospy.is_shutdown():
            if self.is_alive:
                self.tell_search()
            time.sleep(0.1)

    def tell_search(self):
        message = RelocaliserHealth(state=self.state, order=self.order, wish=self.wish, particles=self.particles,
                                    reason="there is more than one mode")
        message.header.stamp = rospy.Time.from_sec(self.time_s)
        self.search.publish(message)

    def scan(self, nis=4.0, x=0.0, found_x=None):
        """One scan of the CEKF and, if `found_x` is given, of the relocaliser."""
        self.particles = 0 if found_x is None else 1000  # if there are any, the supervisor waits for their pose
        self.time_s += SCAN_S
        self.scans += 1
        stamp = rospy.Time.from_sec(self.time_s)
        transform = TransformStamped()
        transform.header.stamp = stamp
        transform.header.frame_id = "odom"
        transform.child_frame_id = "base_link"
        transform.transform.rotation.w = 1.0
        self.tf.publish(TFMessage([transform]))
        if found_x is not None:
            found = PoseWithCovarianceStamped()
            found.header.stamp = stamp
            found.pose.pose.position.x = found_x
            found.pose.pose.orientation.w = 1.0
            self.found.publish(found)
        pose = FilterPose()
        pose.header.stamp = stamp
        pose.pose.pose.position.x = x
        pose.pose.pose.orientation.w = 1.0
        pose.sensor.orientation.w = 1.0
        health = FilterHealth(nis=nis, dof=4, scans=self.scans)
        health.header.stamp = stamp
        self.pose.publish(pose)
        self.health.publish(health)
        if self.is_alive:
            self.tell_search()
        time.sleep(0.02)

    def drive(self, scans, **arguments):
        for _ in range(scans):
            self.scan(**arguments)


class SupervisorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("supervisor_test")
        cls.statuses, cls.poses, cls.map_odom = [], [], []
        rospy.Subscriber("filter_status", FilterStatus, cls.statuses.append)
        rospy.Subscriber("pose", PoseWithCovarianceStamped, cls.poses.append)
        rospy.Subscriber("/tf", TFMessage, cls.watch)
        cls.filters = Filters()
        cls.set_mode = rospy.ServiceProxy("set_mode", SetMode)

    @classmethod
    def watch(cls, message):
        for transform in message.transforms:
            if transform.child_frame_id == "odom":
                cls.map_odom.append((transform.transform.translation.x,
                                     message._connection_header["callerid"]))

    def setUp(self):
        """Back to a CEKF in good order that has rested from the last switch."""
        self.filters.is_alive = True
        self.filters.drive(1)
        self.wait_for(lambda: self.statuses, "a status")
        if self.mode() != FilterStatus.CEKF:
            self.set_mode(mode=FilterStatus.CEKF)
        self.filters.time_s += 30.0
        self.filters.state = RelocaliserHealth.IDLE
        self.filters.drive(3)
        self.wait_for(lambda: self.mode() == FilterStatus.CEKF, "the CEKF")
        del self.filters.resumed[:]

    def mode(self):
        return self.statuses[-1].mode

    def wait_for(self, condition, what):
        deadline = time.time() + PATIENCE_S
        while not condition():
            self.assertLess(time.time(), deadline, "waited in vain for " + what)
            time.sleep(0.02)

    def make_suspicious(self):
        self.filters.drive(1)
        good_s = self.filters.time_s
        self.filters.drive(SUSPICIOUS_SCANS, nis=BAD_NIS)
        self.wait_for(lambda: self.mode() == FilterStatus.RELOCALISING, "the switch")
        self.wait_for(lambda: self.filters.order == self.statuses[-1].order, "the order")
        return good_s

    def test_suspicion_that_lasts_hands_over_from_the_last_good_scan(self):
        self.filters.drive(SUSPICIOUS_SCANS - 1, nis=BAD_NIS)
        self.filters.drive(1)
        time.sleep(0.2)
        self.assertEqual(self.mode(), FilterStatus.CEKF)
        good_s = self.make_suspicious()
        status = self.statuses[-1]
        self.assertIn("do not fit", status.reason)
        self.assertAlmostEqual(status.in_good_order.to_sec(), good_s, places=6)
        self.assertEqual({item.name: item.limit for item in status.evidence}["ambiguity"], 0.5)

    def test_pose_and_map_odom_are_those_of_the_filter_in_charge(self):
        self.make_suspicious()
        self.filters.drive(3, x=1.0, found_x=7.0)
        stamp = rospy.Time.from_sec(self.filters.time_s)
        self.wait_for(lambda: self.poses[-1].header.stamp == stamp, "the pose of the last scan")
        self.assertEqual(self.poses[-1].pose.pose.position.x, 7.0)
        self.wait_for(lambda: self.map_odom[-1][0] == 7.0, "map -> odom of the relocaliser")
        self.filters.state = RelocaliserHealth.ACCEPTED
        self.filters.drive(1, x=1.0)
        self.wait_for(lambda: self.mode() == FilterStatus.CEKF, "the CEKF")
        self.assertIn("took it over", self.statuses[-1].reason)
        self.filters.drive(2, x=1.0)
        self.wait_for(lambda: self.map_odom[-1][0] == 1.0, "map -> odom of the CEKF")

    def test_place_that_the_cekf_refuses_makes_lost(self):
        self.make_suspicious()
        self.filters.state = RelocaliserHealth.REFUSED
        self.filters.drive(1)
        self.wait_for(lambda: self.mode() == FilterStatus.LOST, "LOST")
        self.assertIn("refused", self.statuses[-1].reason)
        order = self.filters.order
        self.filters.time_s += 11.0  # switching/retry_interval_s
        self.filters.drive(2)
        self.wait_for(lambda: self.mode() == FilterStatus.RELOCALISING, "another attempt")
        self.wait_for(lambda: self.filters.order == order + 1, "its order")

    def test_relocaliser_that_dies_in_charge_is_told_of_and_the_cekf_goes_on(self):
        good_s = self.make_suspicious()
        self.filters.is_alive = False
        give_up = time.time() + PATIENCE_S
        while self.mode() != FilterStatus.CEKF:
            self.assertLess(time.time(), give_up)
            self.filters.drive(5)
        self.assertIn("fell silent", self.statuses[-1].reason)
        self.wait_for(lambda: self.filters.resumed, "a call of resume")
        request = self.filters.resumed[-1]
        self.assertEqual(request.way, ResumeRequest.WITHOUT_CLOSING)
        self.assertAlmostEqual(request.since.to_sec(), good_s, places=6)
        before = len(self.map_odom)
        self.wait_for(lambda: len(self.map_odom) > before + 5, "map -> odom that goes on")

    def test_operator_asks_for_a_mode(self):
        answer = self.set_mode(mode="RELOCALISING")
        self.assertTrue(answer.success, answer.message)
        self.wait_for(lambda: self.mode() == FilterStatus.RELOCALISING, "RELOCALISING")
        self.assertIn("operator", self.statuses[-1].reason)
        answer = self.set_mode(mode="CEKF")
        self.assertTrue(answer.success, answer.message)
        self.wait_for(lambda: self.filters.resumed, "a call of resume")
        answer = self.set_mode(mode="cekf")
        self.assertFalse(answer.success)
        self.assertIn("CEKF or RELOCALISING", answer.message)

    def test_wish_of_an_operator_that_the_relocaliser_heard_is_followed(self):
        self.filters.wish += 1
        self.filters.drive(2)
        self.wait_for(lambda: self.mode() == FilterStatus.RELOCALISING, "RELOCALISING")

    def test_filter_that_was_started_anew_has_lost_its_map_and_that_is_told(self):
        self.filters.scans = 0
        self.filters.drive(2)
        self.wait_for(lambda: any("started anew" in s.reason for s in list(self.statuses)), "the loss")
        self.assertEqual(self.mode(), FilterStatus.CEKF)

    def test_map_odom_has_one_owner(self):
        self.filters.drive(3)
        self.wait_for(lambda: self.map_odom, "map -> odom")
        self.assertEqual({owner for _, owner in list(self.map_odom)}, {"/supervisor"})


if __name__ == "__main__":
    rostest.rosrun("hymm", "supervisor", SupervisorTest)
