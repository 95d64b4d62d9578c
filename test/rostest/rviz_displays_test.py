#!/usr/bin/python3
"""RViz draws what it is told where it belongs, follows corrections, and outlives what it cannot use.

Two landmarks of a colour of their own tell where metres are in the picture. The last picture is left as
rviz_displays.png in the folder $HYMM_PICTURES, if that is set."""
import os
import sys
import tempfile
import unittest
from pathlib import Path

import numpy
import rospy
import rostest
from geometry_msgs.msg import Point, PoseStamped
from hymm.msg import (Evidence, FilterHealth, FilterStatus, LandmarkObservation, LevelSet,
                      LevelSetIsland, LevelSetLeaf, LtrGrid)
from hymm.srv import Pause, PauseResponse, PlanPath, PlanPathResponse
from visualization_msgs.msg import Marker, MarkerArray

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from rviz_scene import FREE, OCCUPIED, Scene, landmark  # noqa: E402
from rviz_session import RvizSession, wait_until  # noqa: E402

REFLECTOR, TRUNK = (255, 166, 26), (64, 217, 89)
FREE_COLOUR, OCCUPIED_COLOUR = (77, 90, 103), (241, 97, 77)
BACKGROUND, DOOR, PATH = (28, 32, 38), (90, 230, 210), (255, 89, 191)
CEKF_COLOUR, RELOCALISING_COLOUR = (46, 139, 87), (217, 142, 4)
CELLS = 40
STEP = 8.0  # m, between landmarks
LEFT_ANCHOR, RIGHT_ANCHOR = (-4.0, 20.0), (30.0, 20.0)
PATIENCE_S = 20.0


def half_occupied(alpha, _beta):
    return OCCUPIED if alpha < 0.5 else FREE


def near(pixels, colour, tolerance=12):
    return numpy.abs(pixels.astype(int) - numpy.array(colour)).max(axis=-1) <= tolerance


class Picture:
    """A picture of RViz and the place of its metres, by the two anchors."""

    def __init__(self, image):
        self.image = image
        self.pixels = numpy.asarray(image)
        self.placed = False
        # The view is where much is of the background; panels have orange icons, too.
        view = numpy.nonzero(near(self.pixels, BACKGROUND).mean(axis=0) > 0.3)[0]
        if not len(view):
            return
        rows, columns = numpy.nonzero(near(self.pixels[:, view[0]:view[-1]], REFLECTOR))
        columns = columns + view[0]
        if len(columns) < 100:
            return
        middle = 0.5 * (columns.min() + columns.max())
        left, right = columns < middle, columns >= middle
        self._left = columns[left].mean(), rows[left].mean()
        distance = columns[right].mean() - self._left[0]
        self._scale = distance / (RIGHT_ANCHOR[0] - LEFT_ANCHOR[0])
        self.placed = self._scale > 3.0

    def pixel(self, x, y):
        return (self._left[0] + self._scale * (x - LEFT_ANCHOR[0]),
                self._left[1] - self._scale * (y - LEFT_ANCHOR[1]))

    def at(self, x, y):
        column, row = self.pixel(x, y)
        return tuple(int(c) for c in self.pixels[int(row), int(column)])

    def shows(self, colour, x, y):
        return self.placed and bool(near(numpy.array(self.at(x, y)), colour))

    def count(self, colour):
        return int(near(self.pixels, colour).sum())


class RvizDisplaysTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("rviz_displays_test")
        cls.asked, cls.pauses = [], []
        rospy.Service("plan_path", PlanPath, cls.plan)
        rospy.Service("pause", Pause, cls.pause)
        cls.scene = Scene(3, STEP, CELLS)
        # An uncertain one: its ellipse spans 4 m to either side, and 1 m up and down.
        cls.scene.landmarks.append(landmark(20, 22.0, 4.0, covariance=(4.0, 0, 0, 0.25)))
        for number, place in ((30, LEFT_ANCHOR), (31, RIGHT_ANCHOR)):
            cls.scene.landmarks.append(landmark(number, *place, LandmarkObservation.TYPE_REFLECTOR,
                                                (1e-4, 0, 0, 1e-4), 2.0))
        cls.status = rospy.Publisher("filter_status", FilterStatus, queue_size=2, latch=True)
        cls.health = rospy.Publisher("cekf/health", FilterHealth, queue_size=2)
        cls.sets = rospy.Publisher("level_sets", LevelSet, queue_size=10, latch=True)
        cls.doors = rospy.Publisher("doors", MarkerArray, queue_size=2, latch=True)
        cls.rviz = RvizSession(Path(__file__).resolve().parent / "rviz_displays.rviz")
        cls.scene.publish_map()
        cls.scene.publish_ltrs()
        assert wait_until(cls.scene.is_heard, 40), cls.rviz.log()
        for ltr in range(len(cls.scene.ltrs)):
            cls.scene.publish_occupancy(ltr, half_occupied)

    @classmethod
    def tearDownClass(cls):
        folder = os.environ.get("HYMM_PICTURES")
        if folder and cls.rviz.is_running():
            cls.rviz.picture().save(Path(folder) / "rviz_displays.png")
        cls.rviz.close()

    @classmethod
    def plan(cls, request):
        cls.asked.append(request)
        response = PlanPathResponse(success=True, status="OK", message="A way of 3 doors.",
                                    cost=42.5, cost_with_uncertainty=43.0, length=21.0,
                                    worst_shape_factor=1.05, doors=[3, 7, 12])
        for place in (request.start, Point(14.0, 18.5, 0.0), request.goal):
            pose = PoseStamped()
            pose.pose.position = place
            response.path.poses.append(pose)
        return response

    @classmethod
    def pause(cls, request):
        cls.pauses.append(request.pause)
        return PauseResponse(success=True, message="Paused.")

    def picture_with(self, condition):
        """The first picture that fulfils the condition, which is checked at last."""
        last = []

        def fulfilled():
            last[:] = [Picture(self.rviz.picture())]
            return last[0].placed and condition(last[0])

        failure = Path(tempfile.gettempdir()) / "rviz_displays_failure.png"
        found = wait_until(fulfilled, PATIENCE_S)
        self.assertTrue(self.rviz.is_running(), self.rviz.log())
        if not found:
            last[0].image.save(failure)
        self.assertTrue(last[0].placed, "The two anchors are not in the picture.")
        self.assertTrue(found, f"The picture is in {failure}.\n" + self.rviz.log())
        return last[0]

    def test_1_landmarks_have_the_colour_of_their_type_and_their_ellipse(self):
        picture = self.picture_with(lambda p: p.shows(TRUNK, 22.2, 4.0))
        for x in (18.5, 25.5):
            self.assertTrue(picture.shows(TRUNK, x, 4.0), picture.at(x, 4.0))
        for x, y in ((17.5, 4.0), (26.5, 4.0), (22.0, 5.4), (22.0, 2.6), (25.5, 4.9)):
            self.assertTrue(picture.shows(BACKGROUND, x, y), (x, y, picture.at(x, y)))

    def test_2_layers_lie_on_their_triangles(self):
        picture = self.picture_with(lambda p: p.shows(OCCUPIED_COLOUR, 2.0, 2.0))
        # The first LTR has its alpha along x.
        self.assertTrue(picture.shows(OCCUPIED_COLOUR, 3.7, 2.5), picture.at(3.7, 2.5))
        self.assertTrue(picture.shows(FREE_COLOUR, 4.3, 2.5), picture.at(4.3, 2.5))
        # The second from the opposite corner, towards smaller x.
        self.assertTrue(picture.shows(OCCUPIED_COLOUR, 6.0, 6.0), picture.at(6.0, 6.0))
        self.assertTrue(picture.shows(FREE_COLOUR, 2.5, 7.0), picture.at(2.5, 7.0))
        self.assertTrue(picture.shows(BACKGROUND, 17.0, 9.0), picture.at(17.0, 9.0))

    def test_3_a_correction_moves_the_texture_along(self):
        moved = self.scene.landmarks[8]  # the corner of the lattice, at (16, 16)
        moved.position.y += 3.0
        self.scene.publish_update([moved])
        # Of the LTR with L1 there: half occupied up to alpha 1/2.
        place = 16.0 - 0.15 * STEP, 19.0 - 0.15 * 3.0 - 0.15 * (19.0 - 8.0)
        picture = self.picture_with(lambda p: p.shows(OCCUPIED_COLOUR, 15.2, 17.2))
        self.assertTrue(picture.shows(OCCUPIED_COLOUR, *place), picture.at(*place))
        beyond = 16.0 - 0.7 * STEP, 19.0 - 0.7 * 3.0 - 0.15 * (19.0 - 8.0)
        self.assertTrue(picture.shows(FREE_COLOUR, *beyond), picture.at(*beyond))

    def test_4_level_sets_are_filled_by_island_and_value(self):
        def level_set(value, leaves):
            message = LevelSet(value=value, map_version=1, computed_version=1, complete=True,
                               leaves=[LevelSetLeaf(*leaf) for leaf in leaves],
                               islands=[LevelSetIsland(1, 16.0)], vehicle_island=1)
            message.header.frame_id = "map"
            self.sets.publish(message)

        self.assertTrue(wait_until(lambda: self.sets.get_num_connections() > 0, PATIENCE_S))
        level_set(10.0, [(20.0, 12.0, 4.0, 1), (26.0, 12.0, 4.0, 2)])
        level_set(20.0, [(20.0, 12.0, 2.0, 1)])
        picture = self.picture_with(
            lambda p: p.shows(BACKGROUND, 23.0, 12.0) and not p.shows(BACKGROUND, 26.0, 12.0)
            and p.at(20.0, 12.0) != p.at(21.6, 12.0))
        inside, around, other = (picture.at(x, 12.0) for x in (20.0, 21.6, 27.0))
        self.assertGreater(sum(inside), sum(around) + 60)  # the higher value is brighter
        self.assertGreater(max(abs(a - b) for a, b in zip(around, other)), 60)  # another island
        self.assertEqual(picture.at(18.3, 13.7), around)
        self.assertTrue(picture.shows(BACKGROUND, 22.4, 12.0), picture.at(22.4, 12.0))

    def test_5_doors_are_drawn(self):
        marker = Marker(ns="doors", type=Marker.LINE_LIST,
                        points=[Point(8.0, 2.0, 0.0), Point(8.0, 6.0, 0.0)])
        marker.header.frame_id = "map"
        self.doors.publish(MarkerArray(markers=[marker]))
        picture = self.picture_with(lambda p: p.shows(DOOR, 8.0, 3.0))
        self.assertTrue(picture.shows(DOOR, 8.0, 5.8), picture.at(8.0, 5.8))
        self.assertFalse(picture.shows(DOOR, 8.0, 6.4), picture.at(8.0, 6.4))

    def test_6_the_panel_tells_mode_and_reason(self):
        self.status.publish(FilterStatus(
            mode=FilterStatus.RELOCALISING, reason="5 of 7 observations are ambiguous.",
            evidence=[Evidence(name="ambiguity", value=0.71, limit=0.5)]))
        self.picture_with(lambda p: p.count(RELOCALISING_COLOUR) > 3000)
        self.status.publish(FilterStatus(mode=FilterStatus.CEKF, reason="The CEKF holds."))
        picture = self.picture_with(lambda p: p.count(CEKF_COLOUR) > 3000)
        self.assertLess(picture.count(RELOCALISING_COLOUR), 100)
        self.health.publish(FilterHealth(nis=8.8, dof=8, ambiguity=0.1, landmarks=12, scans=99))
        # White letters on it.
        rows, columns = numpy.nonzero(near(picture.pixels, CEKF_COLOUR))
        banner = picture.pixels[rows.min():rows.max(), columns.min():columns.max()]
        self.assertGreater(near(banner, (255, 255, 255)).sum(), 100)
        # The middle one of three buttons, somewhere below.
        for y in range(rows.max() + 10, picture.image.height - 40, 12):
            self.rviz.click((columns.min() + columns.max()) / 2, y)
            if wait_until(lambda: self.pauses, 0.3):
                break
        self.assertEqual(self.pauses, [True])

    def test_7_two_clicks_ask_for_a_path_and_show_it(self):
        picture = self.picture_with(lambda p: True)
        start, goal = (12.0, 20.5), (20.0, 20.5)
        self.rviz.click(*picture.pixel(*start))
        self.picture_with(lambda p: p.shows(PATH, *start))
        self.rviz.click(*picture.pixel(*goal))
        picture = self.picture_with(lambda p: p.shows(PATH, 14.0, 18.5))
        self.assertEqual(len(self.asked), 1)
        # What it costs stands above its end.
        column, row = (round(c) for c in picture.pixel(goal[0] + 1.0, goal[1] + 1.0))
        text = picture.pixels[row - 60:row, column:column + 150]
        self.assertGreater(near(text, (255, 255, 255), 60).sum(), 50)
        for asked, place in ((self.asked[0].start, start), (self.asked[0].goal, goal)):
            self.assertAlmostEqual(asked.x, place[0], delta=0.2)  # three pixels
            self.assertAlmostEqual(asked.y, place[1], delta=0.2)

    def test_8_what_cannot_be_used_changes_nothing(self):
        before = self.picture_with(lambda p: p.shows(OCCUPIED_COLOUR, 2.0, 2.0))
        wrong = [LtrGrid(ltr=0, layer="occupancy", model="occupancy", alpha_cells=CELLS,
                         beta_cells=CELLS, channels=1, cells=[FREE] * 7),
                 LtrGrid(ltr=0, layer="occupancy", model="fractal", alpha_cells=1, beta_cells=1,
                         channels=1, cells=[FREE]),
                 LtrGrid(ltr=0, layer="occupancy", model="occupancy", alpha_cells=2**32 - 1,
                         beta_cells=2**32 - 1, channels=2**32 - 1, cells=[]),
                 LtrGrid(ltr=4000000, layer="", model="", cells=[])]
        for message in wrong:
            self.scene.grids.publish(message)
        nan = float("nan")
        self.scene.publish_update([landmark(1, nan, 0.0)])
        self.scene.publish_update([landmark(1, 50.0, 50.0, covariance=(-1.0, 0, 0, 1.0))])
        self.sets.publish(LevelSet(value=nan, leaves=[LevelSetLeaf(nan, 0, 1, 0)]))
        self.sets.publish(LevelSet(value=5.0, leaves=[LevelSetLeaf(0, 0, -1, 0)]))
        self.doors.publish(MarkerArray(markers=[Marker(ns="doors", points=[Point(nan, 0, 0)] * 3)]))
        # All have been taken once a later message shows.
        self.scene.publish_occupancy(7, lambda alpha, beta: FREE)
        after = self.picture_with(lambda p: p.shows(FREE_COLOUR, 15.2, 17.2))
        self.assertEqual(after.at(2.0, 2.0), before.at(2.0, 2.0))
        self.assertEqual(after.at(4.3, 2.5), before.at(4.3, 2.5))


if __name__ == "__main__":
    rostest.rosrun("hymm", "rviz_displays", RvizDisplaysTest)
