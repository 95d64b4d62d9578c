#!/usr/bin/python3
"""Wiring of the node door_planner: requests are answered over the map that messages tell, and the plan follows."""
import math
import threading
import time
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovarianceStamped
from hymm.msg import (Landmark, LandmarkMap, Ltr, LtrGrid, LtrMap, PlanPathAction, PlanPathActionGoal,
                      PlanPathGoal)
from hymm.srv import PlanPath
from nav_msgs.msg import Path
from nav_msgs.srv import GetPlan
from rosgraph_msgs.msg import Log
from visualization_msgs.msg import MarkerArray

from waiting import wait_for_links

WAIT_S = 60.0  # only a node that is broken needs it
EDGE_M = 12.0
CELLS = 60
SQUARES = 4  # in a row


def wait_for(condition):
    end = time.monotonic() + WAIT_S
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


def landmark_map(version, shift=0.0):
    """The corners of a row of squares."""
    message = LandmarkMap(version=version)
    message.header.frame_id = "map"
    message.header.stamp = rospy.Time.from_sec(100.0 + version)
    for i in range(2 * (SQUARES + 1)):
        landmark = Landmark(id=i, observations=10)
        landmark.position.x, landmark.position.y = EDGE_M * (i // 2), EDGE_M * (i % 2) + shift
        landmark.covariance = [1e-4, 0.0, 0.0, 1e-4]
        message.landmarks.append(landmark)
    return message


def ltr_map():
    """Two LTRs a square: 2 s with its right angle at the lower left, 2 s + 1 at the upper right."""
    message = LtrMap(landmark_version=1)
    message.header.frame_id = "map"
    for s in range(SQUARES):
        corner = 2 * s
        left = 2 * s - 1 if s > 0 else -1
        right = 2 * s + 2 if s + 1 < SQUARES else -1
        common = dict(alpha_cells=CELLS, beta_cells=CELLS, shape_factor=1.0)
        message.ltrs.append(Ltr(id=2 * s, landmark_ids=[corner, corner + 2, corner + 1],
                                neighbours=[-1, 2 * s + 1, left], **common))
        message.ltrs.append(Ltr(id=2 * s + 1, landmark_ids=[corner + 3, corner + 1, corner + 2],
                                neighbours=[-1, 2 * s, right], **common))
    return message


def grid(ltr, log_odds=-3.0, occupied_rows=()):
    cells = [3.0 if j in occupied_rows else log_odds for j in range(CELLS) for _ in range(CELLS - j)]
    message = LtrGrid(ltr=ltr, layer="occupancy", model="occupancy", alpha_cells=CELLS,
                      beta_cells=CELLS, channels=1, revision=1, cells=cells)
    message.header.frame_id = "map"
    return message


class DoorPlannerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("door_planner_test")
        cls.plans, cls.doors, cls.status = [], [], {}
        rospy.Subscriber("plan", Path, cls.plans.append)
        rospy.Subscriber("doors", MarkerArray, cls.doors.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.diagnose)
        cls.maps = rospy.Publisher("landmarks", LandmarkMap, queue_size=10)
        cls.ltrs = rospy.Publisher("ltrs", LtrMap, queue_size=10)
        cls.grids = rospy.Publisher("ltr_grids", LtrGrid, queue_size=100)
        cls.poses = rospy.Publisher("pose", PoseWithCovarianceStamped, queue_size=10)
        cls.goals = rospy.Publisher("move_base_simple/goal", PoseStamped, queue_size=10)
        rospy.wait_for_service("plan_path", WAIT_S)
        cls.plan_path = rospy.ServiceProxy("plan_path", PlanPath)
        cls.make_plan = rospy.ServiceProxy("make_plan", GetPlan)
        publishers = (cls.maps, cls.ltrs, cls.grids, cls.poses, cls.goals)
        assert wait_for(lambda: all(p.get_num_connections() for p in publishers))

    @classmethod
    def diagnose(cls, message):
        for status in message.status:
            cls.status[status.name] = (status.message, {v.key: v.value for v in status.values})

    def ask(self, x=42.0, y=6.0, plan_path=None, **fields):
        fields.setdefault("from_pose", False)
        fields.setdefault("start", Point(3.0, 4.0, 0.0))
        return (plan_path or self.plan_path)(goal=Point(x, y, 0.0), tolerance=fields.pop("tolerance", 0.0),
                                             lowest_information=fields.pop("lowest_information", 0.0), **fields)

    def test_1_before_a_map_it_says_so(self):
        answer = self.ask()
        self.assertFalse(answer.success)
        self.assertEqual(answer.status, "NO_MAP")
        self.assertTrue(wait_for(lambda: any(
            "No local triangular region" in text for text, _ in list(self.status.values()))))

    def test_2_it_plans_over_the_map(self):
        self.maps.publish(landmark_map(1))
        self.ltrs.publish(ltr_map())
        for ltr in range(2 * SQUARES):
            self.grids.publish(grid(ltr))
        self.assertTrue(wait_for(lambda: self.ask().success))
        self.assertTrue(wait_for(lambda: abs(self.ask().cost - self.ask().length) < 1e-3), "all grids are known")
        answer = self.ask()
        self.assertEqual(answer.status, "OK")
        self.assertAlmostEqual(answer.length, math.hypot(39.0, 2.0), places=3)
        self.assertEqual(answer.path.header.frame_id, "map")
        self.assertGreater(len(answer.doors), 5)
        self.assertTrue(wait_for(lambda: self.doors))

    def test_3_it_says_what_is_wrong(self):
        self.assertEqual(self.ask(x=400.0).status, "GOAL_OUTSIDE_MAP")
        self.assertEqual(self.ask(start=Point(-9.0, 0.0, 0.0)).status, "START_OUTSIDE_MAP")
        self.assertEqual(self.ask(x=float("nan")).status, "BAD_REQUEST")
        self.assertEqual(self.ask(lowest_information=1.0).status, "BELOW_INFORMATION")
        answer = self.ask(from_pose=True)
        self.assertEqual(answer.status, "BAD_REQUEST")
        self.assertIn("No pose", answer.message)

    def test_4_many_requests_at_once(self):
        # Connections that stand already: what is asked at once is the planner, not the master, which answers five callers.
        proxies = [rospy.ServiceProxy("plan_path", PlanPath, persistent=True) for _ in range(100)]
        for proxy in proxies:
            self.ask(plan_path=proxy)
        start, statuses = threading.Barrier(len(proxies)), []

        def request(proxy):
            start.wait()
            try:
                statuses.append(self.ask(plan_path=proxy).status)
            except rospy.ServiceException as error:
                statuses.append(str(error))

        threads = [threading.Thread(target=request, args=(proxy,)) for proxy in proxies]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for proxy in proxies:
            proxy.close()
        self.assertEqual(statuses, ["OK"] * 100)

    def test_5_make_plan_answers_too(self):
        start, goal = PoseStamped(), PoseStamped()
        start.header.frame_id = goal.header.frame_id = "map"
        start.pose.position, goal.pose.position = Point(3.0, 4.0, 0.0), Point(42.0, 6.0, 0.0)
        self.assertGreaterEqual(len(self.make_plan(start, goal, 0.0).plan.poses), 2)

    def test_6_a_goal_gives_a_plan_that_follows_the_landmarks(self):
        pose = PoseWithCovarianceStamped()
        pose.header.frame_id = "map"
        pose.pose.pose.position = Point(3.0, 4.0, 0.0)
        self.poses.publish(pose)
        self.assertTrue(wait_for(lambda: self.ask(from_pose=True).success), "the pose")
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position = Point(42.0, 6.0, 0.0)
        self.goals.publish(goal)
        self.assertTrue(wait_for(lambda: self.plan_ends_at(6.0)))
        self.maps.publish(landmark_map(2, shift=1.5))
        self.assertTrue(wait_for(lambda: self.plan_ends_at(7.5)))

    def plan_ends_at(self, y, x=None):
        poses = self.plans[-1].poses if self.plans else []
        if not poses:
            return False
        end = poses[-1].pose.position
        return abs(end.y - y) < 1e-6 and (x is None or abs(end.x - x) < 1e-6)

    def test_7_the_action_answers_and_keeps_its_plan(self):
        client = actionlib.SimpleActionClient("plan_path", PlanPathAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(WAIT_S)))
        client.send_goal(PlanPathGoal(start=Point(3.0, 4.0, 0.0), goal=Point(30.0, 6.0, 0.0)))
        self.assertTrue(client.wait_for_result(rospy.Duration(WAIT_S)))
        self.assertEqual(client.get_result().status, "OK")
        client.send_goal(PlanPathGoal(start=Point(3.0, 4.0, 0.0), goal=Point(300.0, 6.0, 0.0)))
        self.assertTrue(client.wait_for_result(rospy.Duration(WAIT_S)))
        self.assertEqual(client.get_result().status, "GOAL_OUTSIDE_MAP")

    def test_7_a_goal_that_is_cancelled_leaves_the_node_answering(self):
        client = actionlib.SimpleActionClient("plan_path", PlanPathAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(WAIT_S)))
        for k in range(20):
            # New weights each time: all costs are computed anew, so that some cancels come in time.
            client.send_goal(PlanPathGoal(start=Point(3.0, 4.0, 0.0), goal=Point(30.0, 6.0, 0.0),
                                          weights=f"distance {k + 1}"))
            # Goal and cancel come by different topics: a cancel that overtakes its goal is lost.
            deadline = time.time() + WAIT_S
            while client.get_state() == GoalStatus.PENDING and time.time() < deadline:
                time.sleep(0.001)
            client.cancel_goal()
            self.assertTrue(client.wait_for_result(rospy.Duration(WAIT_S)))
            self.assertIn(client.get_state(), (GoalStatus.PREEMPTED, GoalStatus.RECALLED, GoalStatus.SUCCEEDED))
            if client.get_state() == GoalStatus.PREEMPTED:
                self.assertEqual(client.get_result().status, "CANCELLED")
        self.assertEqual(self.ask(start=Point(3.0, 5.5, 0.0), y=7.5).status, "OK")

    def test_7_cancels_that_come_before_their_goals_do_no_harm(self):
        # Of old stamps: actionlib's own server ends the process by what it keeps of such goals.
        goals = rospy.Publisher("plan_path/goal", PlanPathActionGoal, queue_size=100)
        cancels = rospy.Publisher("plan_path/cancel", GoalID, queue_size=100)
        self.assertTrue(wait_for(lambda: goals.get_num_connections() and cancels.get_num_connections()))
        for k in range(2000):
            known = GoalID(stamp=rospy.Time(1), id=f"goal {k}" + "x" * (37 * k % 200))
            cancels.publish(known)
            goals.publish(PlanPathActionGoal(goal_id=known))
            if k % 10 == 0:
                time.sleep(0.005)
        client = actionlib.SimpleActionClient("plan_path", PlanPathAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(WAIT_S)))
        client.send_goal(PlanPathGoal(start=Point(3.0, 4.0, 0.0), goal=Point(30.0, 6.0, 0.0)))
        self.assertTrue(client.wait_for_result(rospy.Duration(WAIT_S)))
        self.assertEqual(client.get_state(), GoalStatus.SUCCEEDED)

    def test_7_weights_and_refinement_can_be_asked_for(self):
        ask = dict(start=Point(3.0, 5.5, 0.0), y=7.5)
        answer = self.ask(**ask)
        self.assertTrue(answer.refined, answer.message)
        self.assertFalse(self.ask(unrefined=True, **ask).refined)
        self.assertAlmostEqual(self.ask(weights="distance 3", **ask).cost, 3.0 * answer.cost, places=2)
        refused = self.ask(weights="mud -1", **ask)
        self.assertEqual(refused.status, "BAD_REQUEST")
        self.assertIn("mud -1", refused.message)

    def test_8_a_plan_that_is_blocked_in_part_is_made_anew(self):
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position = Point(42.0, 7.5, 0.0)
        self.goals.publish(goal)
        self.assertTrue(wait_for(lambda: self.plans[-1].poses))
        self.grids.publish(grid(5, occupied_rows=range(25, 40)))  # from y = 5.5 to 8.5 m, left of x = 36 m
        # The plan before, and the goal's own, may come until then: both go straight on.
        self.assertTrue(wait_for(lambda: self.goes_around(self.plans[-1])))

    @staticmethod
    def goes_around(plan):
        places = [(p.pose.position.x, p.pose.position.y) for p in plan.poses]
        steps = [k / 50.0 for k in range(51)]
        passed = [(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))
                  for a, b in zip(places, places[1:]) for t in steps]
        inside = [y for x, y in passed if 32.5 < x < 35.5]
        return bool(inside) and all(abs(y - 7.0) > 1.5 for y in inside)

    def test_8_z_a_plan_ends_with_the_filter_and_its_landmarks(self):
        self.maps.publish(landmark_map(300))
        # Goals come on another topic: the map must have come before.
        self.assertTrue(wait_for(lambda: self.ask(x=18.0, start=Point(3.0, 5.5, 0.0), y=1.4).success), "the map")
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position = Point(18.0, 6.0, 0.0)
        self.goals.publish(goal)
        # That of the test before may end at the same y, moved along with the map.
        self.assertTrue(wait_for(lambda: self.plan_ends_at(6.0, x=18.0)), "a plan")
        # The filter was started anew: other landmarks have the same ids.
        self.maps.publish(landmark_map(2, shift=1.5))
        self.assertTrue(wait_for(lambda: not self.plans[-1].poses), "the end of the plan")
        # Where the square is now, and where it was.
        self.assertTrue(wait_for(lambda: self.ask(x=18.0, start=Point(3.0, 5.5, 0.0), y=11.8).success))
        self.assertFalse(self.ask(x=18.0, start=Point(3.0, 5.5, 0.0), y=1.4).success)
        self.assertFalse(self.plans[-1].poses)

    def test_9_a_plan_that_is_blocked_is_made_anew_or_given_up(self):
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position = Point(42.0, 7.5, 0.0)
        self.goals.publish(goal)
        self.assertTrue(wait_for(lambda: self.plans[-1].poses))
        for ltr in (4, 5):
            self.grids.publish(grid(ltr, log_odds=3.0))
        self.assertTrue(wait_for(lambda: not self.plans[-1].poses), "the whole width is closed")
        self.assertEqual(self.ask(start=Point(3.0, 5.5, 0.0), y=7.5).status, "NO_PATH")

    def test_9_z_ltrs_that_cannot_be_used_are_counted_and_told_once(self):
        told = []
        rospy.Subscriber("/rosout", Log, lambda log: told.append(log.msg) if "No path goes" in log.msg else None)
        wait_for_links(("/door_planner", rospy.get_name(), "/rosout"))
        message = ltr_map()
        for count in (1, 2):
            message.ltrs[count].alpha_cells = message.ltrs[count].beta_cells = 1 << 20
            self.ltrs.publish(message)
            self.assertTrue(wait_for(lambda: any(f"{count} LTRs are left out of plans" in text
                                                 for text, _ in list(self.status.values()))))
        values = next(values for name, (_, values) in self.status.items() if name.endswith("door planner"))
        self.assertEqual([count for name, count in values.items() if "more cells than plans" in name], ["2"])
        self.assertTrue(wait_for(lambda: told))
        self.assertIn("LTR 1, which has more cells than plans", told[0])
        self.assertEqual(len(told), 1)


if __name__ == "__main__":
    rostest.rosrun("hymm", "door_planner_test", DoorPlannerTest)
