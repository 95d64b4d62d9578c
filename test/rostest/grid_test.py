#!/usr/bin/python3
"""Wiring of the node hymm_grid: the map appears, answers, is exported, outlives a kill, begins anew
with the filter, whether that was reset or killed, and counts what it cannot use; point clouds make the same map as
scans. The recorder tells of such a kill."""
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import unittest
import xmlrpc.client
from pathlib import Path

import rospy
import rostest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from hymm.msg import GridStatus, LtrGrid, LtrMap, PropertySample
from hymm.srv import ExportMap, MatchScan, Pause, QueryProperty
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2

sys.path.insert(0, os.path.dirname(__file__))
from nodes_test import Robot, command  # noqa: E402
from waiting import PATIENCE_S, uri_of, wait_for, wait_for_links  # noqa: E402

POLES = [(x, y) for x in range(8, 60, 7) for y in (-6.0, 5.0)]
LASER_X = 3.78
SCAN_STEP = 0.2  # m: two steps of 0.1 s at 1 m/s


class GridTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("grid_test")
        cls.ltrs, cls.maps, cls.updates, cls.grids, cls.metadata = [], [], [], [], []
        cls.states, cls.diagnostics = [], {}
        rospy.Subscriber("ltrs", LtrMap, cls.ltrs.append)
        rospy.Subscriber("map", OccupancyGrid, cls.maps.append)
        rospy.Subscriber("map_updates", OccupancyGridUpdate, cls.updates.append)
        rospy.Subscriber("map_metadata", MapMetaData, cls.metadata.append)
        rospy.Subscriber("ltr_grids", LtrGrid, cls.grids.append)
        rospy.Subscriber("grid_status", GridStatus, cls.states.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.diagnose)
        cls.lidar_states, cls.lidar_diagnostics = [], {}
        rospy.Subscriber("lidar/grid_status", GridStatus, cls.lidar_states.append)
        cls.clouds = rospy.Publisher("lidar/points", PointCloud2, queue_size=100)
        cls.samples = rospy.Publisher("property_samples", PropertySample, queue_size=100)
        cls.robot = Robot()
        wait_for(lambda: cls.robot.scans.get_num_connections() >= 2 and cls.samples.get_num_connections() >= 1 and
                 cls.clouds.get_num_connections() >= 2 and cls.robot.motion.get_num_connections() >= 3,
                 "those who take scans, clouds, motion and samples")
        cls.wait_for_nodes()
        cls.x = 0.0
        cls.drive(60)
        wait_for(lambda: all(states and states[-1].scans >= 50 for states in (cls.states, cls.lidar_states)),
                 "scans and clouds in grid_status")

    @staticmethod
    def wait_for_nodes():
        """What the filter says before the dense map listens is lost."""
        of_filter = ("cekf/pose", "landmark_updates", "landmarks")
        here = rospy.get_name()
        for space in ("/", "/lidar/"):
            wait_for_links((space + "cekf_slam", space + "hymm_grid", *[space + topic for topic in of_filter]),
                           (space + "hymm_grid", here, space + "grid_status", "/diagnostics"))
        wait_for_links(("/hymm_grid", here, "/ltrs", "/map", "/map_updates", "/map_metadata", "/ltr_grids"))

    @classmethod
    def diagnose(cls, message):
        for status in message.status:
            if status.name == "hymm_grid: dense map":
                cls.diagnostics = {item.key: item.value for item in status.values}
            elif status.name.endswith("lidar/hymm_grid: dense map"):
                cls.lidar_diagnostics = {item.key: item.value for item in status.values}

    @classmethod
    def drive(cls, scans):
        for _ in range(scans):
            cls.x += 0.5 * SCAN_STEP
            laser = cls.x + LASER_X
            near = [(x - laser, y) for x, y in POLES if 0.5 < x - laser < 25.0]
            scan = cls.robot.scan(poles=near)
            cls.clouds.publish(cls.cloud_of(scan))
            cls.robot.drive_with(scan)
            cls.x += 0.5 * SCAN_STEP

    @classmethod
    def cloud_of(cls, scan):
        """What a lidar sees that stands in the place of a laser: obstacles, and the ground."""
        points = []
        for beam, range_m in enumerate(scan.ranges):
            bearing = scan.angle_min + beam * scan.angle_increment
            x, y = math.cos(bearing), math.sin(bearing)
            points += [(r * x, r * y, -0.4) for r in (5.0, 10.0, 20.0) if r < range_m]
            if math.isfinite(range_m):
                points += [(range_m * x, range_m * y, z) for z in (0.5, 1.0)]
        header = scan.header
        header.stamp = rospy.Time.from_sec(cls.robot.time_s + 0.1)  # as drive_with() stamps the scan
        return point_cloud2.create_cloud_xyz32(header, points)

    def query(self, layer, x, y):
        position = PropertySample().position
        position.x, position.y = x, y
        return rospy.ServiceProxy("query_property", QueryProperty)(layer=layer, position=position)

    def place_inside(self):
        """A place of which an LTR knows something: the vehicle has driven there."""
        return self.x - 4.0, 0.3

    def has_free_and_occupied_cells(self):
        cells = self.maps[-1].data if self.maps else []
        return any(0 <= cell < 20 for cell in cells) and any(cell > 65 for cell in cells)

    def test_map_appears_with_its_triangles(self):
        wait_for(lambda: self.ltrs and self.ltrs[-1].ltrs, "LTRs")
        wait_for(self.has_free_and_occupied_cells, "a map with free and occupied cells")
        self.assertAlmostEqual(self.maps[-1].info.resolution, 0.2, places=6)
        self.assertEqual(self.maps[-1].header.frame_id, "map")
        wait_for(lambda: self.metadata, "map_metadata")
        wait_for(lambda: self.grids, "ltr_grids")
        self.assertEqual(self.states[-1].lost_scans, 0)

    def test_clouds_make_the_same_map_as_scans(self):
        query = rospy.ServiceProxy("lidar/query_property", QueryProperty)
        known, alike = 0, 0
        for i in range(40):
            for y in (-2.0, -0.4, 1.2):
                x = 8.0 + 0.3 * i
                position = PropertySample().position
                position.x, position.y = x, y
                of_clouds = query(layer="occupancy", position=position)
                of_scans = self.query("occupancy", x, y)
                if not (of_clouds.known and of_scans.known):
                    continue
                known += 1
                alike += (of_clouds.value > 0.5) == (of_scans.value > 0.5)
        self.assertGreater(known, 50)
        self.assertGreater(alike, 0.98 * known)

    def test_clouds_without_the_fields_needed_are_counted(self):
        cloud = self.cloud_of(self.robot.scan())
        cloud.fields[2].name = "height"
        self.clouds.publish(cloud)
        wait_for(lambda: self.lidar_diagnostics.get("point clouds that cannot be read") == "1",
                      "a cloud without height")

    def test_only_what_changed_is_sent(self):
        wait_for(lambda: self.maps and self.maps[-1].header.stamp == self.robot.scan_stamp,
                 "the whole map, which follows a silence")
        del self.grids[:], self.updates[:]
        self.drive(1)
        wait_for(lambda: self.updates, "an update of the map")
        whole = self.maps[-1].info.width * self.maps[-1].info.height
        self.assertLess(sum(len(update.data) for update in self.updates), whole)
        wait_for(lambda: self.grids, "grids")
        self.assertLessEqual(len({grid.ltr for grid in self.grids}), len(self.ltrs[-1].ltrs))

    def test_new_subscriber_gets_all_grids_and_the_map(self):
        wait_for(lambda: self.grids, "a grid")
        # In a process of its own: a node has one connection a topic.
        for topic in ("/ltr_grids/layer", "/map/info/width"):
            told = subprocess.run(["rostopic", "echo", "-n", "1", topic], timeout=PATIENCE_S,
                                  stdout=subprocess.PIPE, text=True)
            self.assertNotEqual(told.stdout, "", topic)
        grid = self.grids[-1]
        rows = (math.ceil(grid.alpha_cells * (grid.beta_cells - j) / grid.beta_cells)
                for j in range(grid.beta_cells))
        self.assertEqual(len(grid.cells), grid.channels * sum(rows))

    def test_property_is_found_where_it_was_measured(self):
        sample = PropertySample(layer="salinity", value=0.31, variance=0.01,
                                position_covariance=[0.001, 0.0, 0.0, 0.001])
        sample.header.frame_id = "map"
        sample.header.stamp = rospy.Time.from_sec(self.robot.time_s)
        sample.position.x, sample.position.y = self.place_inside()
        self.samples.publish(sample)
        wait_for(lambda: self.query("salinity", *self.place_inside()).known, "the sample")
        answer = self.query("salinity", *self.place_inside())
        self.assertTrue(answer.success)
        self.assertAlmostEqual(answer.value, 0.31, places=5)
        self.assertEqual(answer.model, "gaussian")
        free = self.query("occupancy", *self.place_inside())
        self.assertTrue(free.known)
        self.assertLess(free.value, 0.5)

    def test_queries_that_cannot_be_answered_say_why(self):
        unknown = self.query("sallinity", 5.0, 0.0)
        self.assertFalse(unknown.success)
        self.assertIn("salinity, terrain", unknown.message)
        self.assertIn("No LTR", self.query("occupancy", 5000.0, 0.0).message)
        self.assertIn("finite", self.query("occupancy", float("nan"), 0.0).message)

    def test_export_gives_back_the_cells(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "park")
            service = rospy.ServiceProxy("export_map", ExportMap)
            # The whole map is drawn anew in the silence after the last scan.
            wait_for(lambda: self.is_exported(self.maps[-1], path), "a map with the cells of the exported one")
            answer = service(format="octomap", path=os.path.join(folder, "park.bt"))
            self.assertTrue(answer.success, answer.message)
            self.assertTrue(Path(folder, "park.bt").read_bytes().startswith(b"# Octomap OcTree bin"))
            answer = service(format="geojson", path=os.path.join(folder, "park.geojson"))
            self.assertTrue(answer.success, answer.message)
            features = json.loads(Path(folder, "park.geojson").read_text())["features"]
            kinds = [feature["properties"]["kind"] for feature in features]
            self.assertEqual(kinds.count("ltr"), len(self.ltrs[-1].ltrs))
            self.assertGreaterEqual(kinds.count("landmark"), 4)
            self.assertTrue(features[-1]["geometry"]["coordinates"])
        for bad in ({"format": "tiff", "path": "/tmp/a"}, {"format": "pgm", "path": "a"},
                    {"format": "pgm", "path": "/no/such/folder/a"}):
            answer = service(**bad)
            self.assertFalse(answer.success)
            self.assertNotEqual(answer.message, "")

    def is_exported(self, cells, path):
        """Whether the image that is exported now holds these cells."""
        answer = rospy.ServiceProxy("export_map", ExportMap)(format="pgm", path=path)
        self.assertTrue(answer.success, answer.message)
        told = yaml.safe_load(Path(path + ".yaml").read_text())
        magic, size, depth, pixels = (Path(path).parent / told["image"]).read_bytes().split(b"\n", 3)
        self.assertEqual((magic, depth), (b"P5", b"255"))
        width, height = (int(word) for word in size.split())
        origin = cells.info.origin.position
        if (width, height) != (cells.info.width, cells.info.height) or abs(told["origin"][0] - origin.x) > 1e-6:
            return False
        return all(self.read_back(pixels[(height - 1 - y) * width + x], told)  # the image's first row is the top
                   == self.as_three_values(cells.data[y * width + x]) for y in range(height) for x in range(width))

    @staticmethod
    def read_back(pixel, told):
        share = (255 - pixel) / 255.0
        return 100 if share > told["occupied_thresh"] else 0 if share < told["free_thresh"] else -1

    @staticmethod
    def as_three_values(percent):
        return -1 if percent < 0 else 100 if percent > 65 else 0 if percent < 19.6 else -1

    def test_dynamic_map_and_matching_answer(self):
        wait_for(lambda: self.maps, "a map")
        cells = rospy.ServiceProxy("dynamic_map", GetMap)().map
        self.assertEqual(len(cells.data), cells.info.width * cells.info.height)
        self.assertGreater(len(cells.data), 0)
        answer = rospy.ServiceProxy("match_scan", MatchScan)()
        if answer.success:
            self.assertLess(abs(answer.pose.pose.position.x - self.x), 0.5)
        else:
            self.assertNotEqual(answer.message, "")

    def count_of(self, cause):
        return sum(int(value) for key, value in self.diagnostics.items() if cause in key)

    def test_bad_samples_are_counted(self):
        for layer, value, frame in (("sallinity", 0.3, "map"), ("salinity", float("nan"), "map"),
                                    ("salinity", 0.3, "nowhere")):
            sample = PropertySample(layer=layer, value=value, variance=0.01)
            sample.header.frame_id = frame
            sample.header.stamp = rospy.Time.from_sec(self.robot.time_s)
            sample.position.x, sample.position.y = self.place_inside()
            self.samples.publish(sample)
        wait_for(lambda: self.count_of("layer 'sallinity'") == 1, "an unknown layer")
        wait_for(lambda: self.count_of("layer 'salinity'") == 1, "a value that is no number")
        wait_for(lambda: self.count_of("'nowhere'") == 1, "an unknown frame")

    def test_paused_node_writes_no_scans(self):
        pause = rospy.ServiceProxy("hymm_grid/pause", Pause)
        self.assertTrue(pause(pause=True).success)
        self.drive(5)
        wait_for(lambda: self.count_of("scans while paused") >= 5, "scans that are not written")
        self.assertTrue(pause(pause=False).success)

    def test_zz_killed_node_recovers(self):
        wait_for(lambda: self.ltrs, "LTRs")
        self.kill("/hymm_grid")
        self.wait_for_nodes()
        wait_for(lambda: Robot.is_heard(self.robot.scans, "/cekf_slam", "/hymm_grid"), "its subscription")
        del self.ltrs[:], self.maps[:], self.states[:]
        self.drive(25)
        wait_for(lambda: self.ltrs and self.ltrs[-1].ltrs, "LTRs again")
        wait_for(self.has_free_and_occupied_cells, "a map again")
        wait_for(lambda: self.states and self.states[-1].scans > 0, "scans again")

    def test_zzz_begins_anew_with_the_filter(self):
        wait_for(lambda: self.ltrs and self.ltrs[-1].ltrs, "LTRs")
        before = self.ltrs[-1].landmark_version
        self.robot.time_s -= 100.0
        type(self).x = 0.0
        self.drive(8)
        wait_for(lambda: any(ltrs.landmark_version > before and not ltrs.ltrs
                                  for ltrs in list(self.ltrs)), "a map without LTRs")

    def test_zzzz_begins_anew_with_a_filter_that_was_started_anew(self):
        with tempfile.TemporaryDirectory() as folder:
            recorder = subprocess.Popen(command("recorder", "__name:=recorder", "_output:=" + folder),
                                        preexec_fn=os.setsid)
            try:
                wait_for_links(("/cekf_slam", "/recorder", "/cekf/pose", "/cekf/health", "/landmarks"))
                self.drive(20)
                wait_for(lambda: self.ltrs[-1].ltrs, "LTRs")
                before = self.ltrs[-1].landmark_version
                self.kill("/cekf_slam")
                wait_for_links(("/cekf_slam", "/recorder", "/cekf/pose", "/cekf/health", "/landmarks"))
                self.wait_for_nodes()
                del self.states[:], self.ltrs[:]

                # All this before the new filter's versions have reached those of the old one.
                def writes_scans():
                    self.drive(1)
                    return any(state.scans > 0 and state.landmark_version < before for state in list(self.states))

                def has_new_triangles():
                    self.drive(1)
                    return any(ltrs.ltrs and ltrs.landmark_version < before for ltrs in list(self.ltrs))

                wait_for(writes_scans, "scans in the map of the new filter")
                wait_for(has_new_triangles, "LTRs of the new filter's landmarks")
            finally:
                os.killpg(recorder.pid, signal.SIGINT)
                recorder.wait(timeout=PATIENCE_S)
            self.assertEqual(recorder.returncode, 0)
            events = (Path(folder) / "events.csv").read_text()
            self.assertEqual(events.count("reset"), 1, events)
            self.assertIn("cekf_slam was started anew", events)

    @staticmethod
    def kill(node):
        """Returns when it is there again: the launch starts it anew."""
        uri = uri_of(node)
        os.kill(xmlrpc.client.ServerProxy(uri).getPid("/grid_test")[2], signal.SIGKILL)
        wait_for(lambda: uri_of(node) not in (None, uri), "the return of " + node)


if __name__ == "__main__":
    rostest.rosrun("hymm", "grid", GridTest)
