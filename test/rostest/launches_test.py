#!/usr/bin/python3
"""Launches one after the other, and beside each other, on one master: each has the parameters that it states."""
import os
import sys
import tempfile
import unittest
from pathlib import Path

import rosgraph

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/lib"))
from hostile_suite import Suite, wait_for  # noqa: E402

BUILD = Path(os.environ["HYMM_BUILD_DIR"])
FILES = ["cekf_slam", "hymm_grid", "information_map", "door_planner", "relocaliser", "supervisor", "dead_reckoning"]
SHARED = ["vehicle", "point_clouds", "config_file"]
# Of roslaunch itself.
NOT_OURS = ["roslaunch", "run_id", "rosdistro", "rosversion"]
TRUCK = """
vehicle: {name: truck, laser: {x_m: 1.0, y_m: 0.2, yaw_rad: 0.0}, noise: {speed_deviation_mps: 0.07}}
point_clouds: {min_height_m: 0.5}
cekf_slam: {landmark_rate_hz: 2.0, gps: {enabled: true}}
hymm_grid: {layers: salinity gaussian}
door_planner: {footprint: {width_m: 2.5}}
relocaliser: {seed: 7}
"""
CART = """
vehicle: {name: cart, noise: {speed_deviation_relative: 0.03}}
cekf_slam: {motion_input: odom}
"""
# A user's own launch file; its parameters stand before and behind what it includes.
OWN = """
<launch>
  <param name="vehicle" value="utility_car"/>
  <include file="$(find hymm)/launch/cekf_slam.launch"/>
  <param name="cekf_slam/landmark_rate_hz" value="3"/>
</launch>
"""
IN_NAMESPACE = """
<launch>
  <arg name="ns"/>
  <arg name="config" default=""/>
  <include file="$(find hymm)/launch/cekf_slam.launch" ns="$(arg ns)">
    <arg name="config" value="$(arg config)"/>
  </include>
</launch>
"""


class Launches(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.truck, self.cart = self.write("truck.yaml", TRUCK), self.write("cart.yaml", CART)
        self.new_master()

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def new_master(self):
        suite = Suite(BUILD, self.folder)
        self.addCleanup(suite.end)
        self.master = rosgraph.Master("/launches_test")

    def launch(self, file, *arguments):
        """The parameters on the master once the nodes of a launch start, which is then ended."""
        log = self.folder / "launch.log"
        file = [file] if isinstance(file, Path) else ["hymm", f"{file}.launch"]
        with open(log, "w") as output:
            process = Suite.begin(["roslaunch", *file, *arguments], log=output)
        started = wait_for(lambda: "started with pid" in log.read_text() or process.poll() is not None, 60.0)
        running = process.poll() is None
        parameters = {name: value for name, value in self.master.getParam("/").items() if name not in NOT_OURS}
        process.send_signal(2)
        process.wait(60.0)
        self.assertTrue(started and running, log.read_text()[-2000:])
        return parameters

    def launch_on_new_master(self, *arguments):
        self.new_master()
        return self.launch(*arguments)

    def test_one_without_a_configuration_has_the_defaults(self):
        first = self.launch("bringup", f"config:={self.truck}", "map_pose:=1 2 3")
        self.assertEqual(first["cekf_slam"]["landmark_rate_hz"], 2.0)
        second = self.launch("bringup")
        self.assertEqual(second, self.launch_on_new_master("bringup"))

    def test_a_configuration_is_not_mixed_with_that_of_the_launch_before(self):
        self.launch("bringup", f"config:={self.truck}")
        second = self.launch("bringup", f"config:={self.cart}")
        self.assertEqual(second["vehicle"], {"name": "cart", "noise": {"speed_deviation_relative": 0.03}})
        self.assertEqual(second, self.launch_on_new_master("bringup", f"config:={self.cart}"))

    def test_each_file_clears_its_node_and_what_is_shared_and_nothing_else(self):
        for file in FILES:
            with self.subTest(file):
                for name in FILES + SHARED + ["somebody_else"]:
                    self.master.setParam(f"/{name}", {"left_over": 1})
                parameters = self.launch(file)
                left = [name for name, value in parameters.items() if value == {"left_over": 1}]
                self.assertCountEqual(left, [name for name in FILES if name != file] + ["somebody_else"])
                self.assertNotIn("left_over", parameters[file])

    def test_a_playback_clears_the_nodes_that_it_alone_has(self):
        for name in ("recorder", "playback"):
            self.master.setParam(f"/{name}", {"left_over": 1})
        parameters = self.launch("playback", f"bag:={ROOT / 'bags/car_park.bag'}", f"output:={self.folder / 'out'}",
                                 f"config:={ROOT / 'config/datasets/car_park.yaml'}")
        self.assertEqual(parameters["recorder"], {"output": str(self.folder / "out")})
        self.assertNotIn("left_over", parameters["playback"])

    def test_a_launch_file_that_includes_ours_keeps_its_own_parameters(self):
        self.launch("cekf_slam", f"config:={self.truck}")
        parameters = self.launch(self.write("own.launch", OWN))
        self.assertEqual(parameters["vehicle"], "utility_car")
        self.assertEqual(parameters["cekf_slam"]["landmark_rate_hz"], 3)
        self.assertFalse(parameters["cekf_slam"]["gps"]["enabled"])

    def test_a_robot_in_another_namespace_keeps_its_parameters(self):
        robot = self.write("robot.launch", IN_NAMESPACE)
        first = self.launch(robot, "ns:=first", f"config:={self.truck}")["first"]
        self.assertEqual(first["vehicle"]["name"], "truck")
        both = self.launch(robot, "ns:=second")
        self.assertEqual(both["first"], first)
        self.assertNotIn("vehicle", both["second"])


if __name__ == "__main__":
    unittest.main()
