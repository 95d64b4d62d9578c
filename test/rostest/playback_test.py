#!/usr/bin/python3
"""playback.launch leaves what hymm_offline leaves: for a car with encoders, for a robot that has
only `odom`, and for one whose own detector publishes `detections`."""
import contextlib
import csv
import json
import os
import re
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import rosbag

ROOT = Path(__file__).parents[2]
DURATION_S = 15
RATE = 5
SCANS_HZ = 5  # of the simulated laser and detector


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return str(listener.getsockname()[1])


def read_table(path, delimiter=","):
    with open(path, newline="") as file:
        return list(csv.reader(file, delimiter=delimiter))


class Playback(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name)

    def play(self, bag, config, *arguments):
        port = free_port()
        with self.logged_diagnostics(port):
            return self.launch(port, bag, config, *arguments)

    @contextlib.contextmanager
    def logged_diagnostics(self, port):
        log = subprocess.Popen(
            [Path(__file__).resolve().parent / "diagnostics_log.py", self.path / "diagnostics.jsonl"],
            env={**os.environ, "ROS_MASTER_URI": f"http://localhost:{port}"},
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            yield
        finally:
            log.kill()
            log.wait()

    def launch(self, port, bag, config, *arguments):
        return subprocess.run(
            ["roslaunch", "--port", port, "hymm", "playback.launch", f"bag:={bag}",
             f"config:={config}", f"rate:={RATE}", f"output:={self.path / 'live'}",
             *arguments],
            env={**os.environ, "ROS_MASTER_URI": f"http://localhost:{port}",
                 "ROS_HOME": str(self.path / "ros")}, timeout=90, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def run_both(self, overlay, *simulation, renamed=()):
        """`renamed`: the robot's names of topics, by ours."""
        bag, config = self.path / "robot.bag", self.path / "robot.yaml"
        config.write_text(overlay)
        self.run_command("rosrun", "hymm", "simulate_world", "--world", "park", "--seed", "7",
                         "--duration", DURATION_S, "--output", bag, *simulation)
        self.run_command("rosrun", "hymm", "hymm_offline", "--bag", bag, "--config", config,
                         "--output", self.path / "offline")
        done = self.play(self.bag_with_other_names(bag, dict(renamed)), config,
                         *(f"{ours}_topic:={theirs}" for ours, theirs in renamed))
        self.assertEqual(done.returncode, 0, done.stdout)

    def bag_with_other_names(self, bag, names):
        if not names:
            return bag
        other = self.path / "other_names.bag"
        with rosbag.Bag(str(bag)) as source, rosbag.Bag(str(other), "w") as target:
            for topic, message, stamp in source.read_messages(raw=True):
                target.write(names.get(topic.strip("/"), topic), message, stamp, raw=True)
        return other

    def run_command(self, *command):
        done = subprocess.run([str(word) for word in command], timeout=90, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_bag_that_cannot_be_played_is_told_at_once(self):
        shipped = ROOT / "bags" / "car_park.bag"
        bag, config = self.path / "cut.bag", ROOT / "config" / "datasets" / "car_park.yaml"
        bag.write_bytes(shipped.read_bytes()[:100000])
        begin = time.monotonic()
        self.assertIn("cut.bag: the bag is cut off", self.play(bag, config).stdout)
        self.assertLess(time.monotonic() - begin, 40.0)

    def test_topics_of_other_names_are_told_with_those_of_the_bag(self):
        bag, config = ROOT / "bags" / "car_park.bag", ROOT / "config" / "datasets" / "car_park.yaml"
        told = self.play(bag, config, "scan_topic:=/front/scan").stdout
        self.assertIn("nobody publishes /front/scan (for cekf_slam)", told)
        self.assertIn("/scan (sensor_msgs/LaserScan)", told)

    def test_player_that_dies_on_the_way_is_not_the_end(self):
        port = free_port()
        environment = {**os.environ, "ROS_MASTER_URI": f"http://localhost:{port}",
                       "ROS_HOME": str(self.path / "ros"), "ROSCONSOLE_STDOUT_LINE_BUFFERED": "1",
                       "PYTHONUNBUFFERED": "1"}  # for roslaunch, which is read while it runs
        launch = subprocess.Popen(
            ["roslaunch", "--port", port, "hymm", "playback.launch", f"bag:={ROOT / 'bags/car_park.bag'}",
             f"config:={ROOT / 'config/datasets/car_park.yaml'}"],
            env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(launch.stdout.close)
        told, is_killed = "", False
        for line in launch.stdout:
            told += line
            # Either may come first: what the player says, and what roslaunch says of it.
            started = re.search(r"process\[player-\d+\]: started with pid \[(\d+)\]", told)
            if started and "Playing." in told and not is_killed:
                os.kill(int(started[1]), signal.SIGKILL)
                is_killed = True
        launch.wait()
        self.assertRegex(told, r"not played to its end: the player ended at \d+\.\d s of 178\.\d s")
        self.assertNotIn("all of it is processed", told)

    def test_part_of_a_bag_that_the_user_chose_is_played_to_its_end(self):
        config = ROOT / "config" / "datasets" / "car_park.yaml"
        bag = self.path / "a drive.bag"
        bag.symlink_to(ROOT / "bags" / "car_park.bag")
        told = self.play(bag, config, "play_args:=-s 20 -u 15").stdout
        self.assertIn("all of it is processed", told)
        stamps = [float(row[0]) for row in read_table(self.path / "live" / "trajectory.tum", " ")]
        self.assertGreater(stamps[-1] - stamps[0], 10.0)
        self.assertLess(stamps[-1] - stamps[0], 15.1)

    def expect_equal_results(self, scans):
        live, offline = (json.loads((self.path / kind / "summary.json").read_text())
                         for kind in ("live", "offline"))
        self.assertEqual(offline["scans"], scans)
        self.assertGreater(offline["landmarks"], 3)
        for key in ("scans", "landmarks", "observations", "associated", "rejected",
                    "mode_switches", "seed"):
            self.assertEqual(live[key], offline[key], key)
        self.assertEqual(live["dropped_scans"], 0)
        self.assertLessEqual(live["subsystem_cpu_s"].keys(), offline["subsystem_cpu_s"].keys())
        self.assertIn("hymm_grid", live["subsystem_cpu_s"])
        self.expect_close("trajectory.tum", " ", columns=8)
        self.expect_close("landmarks.csv", ",", columns=9)
        self.expect_same_modes()

    def expect_diagnostics_agree(self):
        """What the nodes told last is what the recorder wrote."""
        with open(self.path / "diagnostics.jsonl") as file:
            told = dict(json.loads(line) for line in file)
        live = json.loads((self.path / "live" / "summary.json").read_text())
        for key, node, value in (
                ("scans", "cekf_slam: filter", "scans used"),
                ("landmarks", "cekf_slam: filter", "landmarks"),
                ("observations", "cekf_slam: filter", "observations"),
                ("associated", "cekf_slam: filter", "observations associated"),
                ("rejected", "cekf_slam: filter", "observations rejected"),
                ("map_corrections", "cekf_slam: filter", "map corrections"),
                ("mode_switches", "supervisor: supervisor", "mode switches"),
                ("ltrs", "hymm_grid: dense map", "LTRs"),
                ("scans", "supervisor: supervisor", "poses")):
            self.assertEqual(int(told[node][value]), live[key], f"{node}: {value}")
        dropped = (int(told["cekf_slam: filter"]["scans refused"]) +
                   int(told["cekf_slam: inputs"]["dropped scans"]))
        self.assertEqual(dropped, live["dropped_scans"])
        for node in ("cekf_slam", "hymm_grid", "information_map", "door_planner", "relocaliser",
                     "supervisor", "recorder", "playback"):
            inputs = told[f"{node}: inputs"]
            self.assertTrue(any(key.endswith(" rate [Hz, wall]") for key in inputs), node)

    def expect_equal_maps(self):
        """The dense map of a playback without drops is that of an offline run."""
        live, offline = self.path / "live", self.path / "offline"
        summaries = [json.loads((folder / "summary.json").read_text())
                     for folder in (live, offline)]
        self.assertEqual(summaries[0]["ltrs"], summaries[1]["ltrs"])
        self.expect_close("ltrs.csv", ",", columns=11)
        self.assertEqual((live / "map.yaml").read_text(), (offline / "map.yaml").read_text())
        cells = [(folder / "map.pgm").read_bytes() for folder in (live, offline)]
        self.assertEqual(len(cells[0]), len(cells[1]))
        # The filters' estimates differ by rounding (a worker here, none there): so may a cell at
        # whose border a beam ends.
        differing = sum(a != b for a, b in zip(*cells))
        self.assertLess(differing, 1e-4 * len(cells[0]))
        self.assertGreater(cells[0].count(0), 100)  # occupied
        memory = [read_table(folder / "map_memory.csv") for folder in (live, offline)]
        self.assertEqual([row[0] for row in memory[0]], [row[0] for row in memory[1]])

    def expect_same_modes(self):
        modes = [[row[-1] for row in read_table(self.path / kind / "health.csv")]
                 for kind in ("live", "offline")]
        self.assertEqual(modes[0], modes[1])
        self.assertEqual(set(modes[0]), {"mode", "CEKF"})
        events = [read_table(self.path / kind / "events.csv") for kind in ("live", "offline")]
        self.assertEqual(events[0], events[1])

    def expect_close(self, name, delimiter, columns):
        live, offline = (read_table(self.path / kind / name, delimiter)
                         for kind in ("live", "offline"))
        self.assertEqual(len(live), len(offline))
        numbers = 0
        for live_row, offline_row in zip(live, offline):
            self.assertEqual(len(live_row), columns)
            for a, b in zip(live_row, offline_row):
                try:
                    self.assertAlmostEqual(float(a), float(b), delta=1e-6)
                    numbers += 1
                except ValueError:  # a name
                    self.assertEqual(a, b)
        self.assertGreater(numbers, len(live))

    def test_car_with_encoders(self):
        self.run_both("vehicle: simulated_car\nrelocaliser: {seed: 7}\n")
        self.expect_equal_results(scans=DURATION_S * SCANS_HZ)
        self.assertEqual(json.loads((self.path / "live" / "summary.json").read_text())["seed"], 7)
        self.expect_diagnostics_agree()
        self.expect_equal_maps()

    def test_robot_with_odom_only(self):
        self.run_both("vehicle: simulated_car\ncekf_slam: {motion_input: odom}\n",
                      "--motion", "odom")
        self.expect_equal_results(scans=DURATION_S * SCANS_HZ)

    def test_robot_with_its_own_detector_and_names_of_topics(self):
        # The vehicle is a file beside the configuration: nodes find it as hymm_offline does.
        shipped = ROOT / "config" / "vehicles" / "simulated_car.yaml"
        (self.path / "robots").mkdir()
        (self.path / "robots" / "mine.yaml").write_text(shipped.read_text())
        self.run_both("vehicle: robots/mine.yaml\n"
                      "cekf_slam: {observation_input: detections}\n", "--detections",
                      renamed=[("detections", "/front/trees"), ("dead_reckoning", "/can/wheels")])
        self.expect_equal_results(scans=DURATION_S * SCANS_HZ)


if __name__ == "__main__":
    unittest.main()
