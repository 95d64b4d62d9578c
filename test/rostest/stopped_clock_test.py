#!/usr/bin/python3
"""A simulated clock that nobody runs is told, once poses come, and no longer when it runs."""
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from hymm.msg import FilterHealth, FilterPose
from rosgraph_msgs.msg import Clock

from waiting import wait_for, wait_for_links

TOLD = "use_sim_time is true, but there is no /clock"


class StoppedClock(unittest.TestCase):
    def setUp(self):
        rospy.init_node("stopped_clock_test")
        self.told = []
        rospy.Subscriber("/diagnostics", DiagnosticArray, self.take)
        self.pose = rospy.Publisher("cekf/pose", FilterPose, queue_size=100)
        self.health = rospy.Publisher("cekf/health", FilterHealth, queue_size=100)
        self.clock = rospy.Publisher("/clock", Clock, queue_size=100)
        wait_for_links((rospy.get_name(), "/supervisor", "/cekf/pose", "/cekf/health", "/clock"))

    def take(self, message):
        for status in message.status:
            if status.name == "supervisor: supervisor":
                self.told.append(status)

    def scan(self):
        pose, health = FilterPose(), FilterHealth()
        pose.header.stamp = health.header.stamp = rospy.Time(100)
        pose.pose.pose.orientation.w = pose.sensor.orientation.w = 1.0
        self.pose.publish(pose)
        self.health.publish(health)

    def wait_for_news(self):
        count = len(self.told)
        wait_for(lambda: len(self.told) > count + 1, "diagnostics")  # one may have been on its way
        return self.told[-1]

    def test_it_is_told_while_poses_come_and_no_clock_runs(self):
        self.assertNotIn(TOLD, self.wait_for_news().message)
        self.scan()
        wait_for(lambda: TOLD in self.told[-1].message, "a word about the clock")
        self.assertEqual(self.told[-1].level, DiagnosticStatus.ERROR)
        self.clock.publish(Clock(rospy.Time(100)))
        wait_for(lambda: TOLD not in self.told[-1].message, "diagnostics without it")


if __name__ == "__main__":
    rostest.rosrun("hymm", "stopped_clock", StoppedClock)
