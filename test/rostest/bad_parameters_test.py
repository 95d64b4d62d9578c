#!/usr/bin/python3
"""Parameters that no node can use: it names each of them in a sentence, and ends with exit code 1."""
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/lib"))
from hostile_suite import Suite  # noqa: E402

BUILD = Path(os.environ["HYMM_BUILD_DIR"])
NODES = ["cekf_slam", "hymm_grid", "information_map", "door_planner", "relocaliser", "supervisor",
         "dead_reckoning", "recorder", "playback"]
PATIENCE_S = 60.0


def parameters_of(group):
    """Name, default and range of each parameter, as the reference tells them."""
    text = subprocess.run([BUILD / "devel/lib/hymm/hymm_parameters", "--only", group],
                          stdout=subprocess.PIPE, text=True, check=True).stdout
    rows = re.findall(r"^\| `([^`]+)` \|[^|]*\| ([^|]*) \| ([^|]*) \|", text, re.MULTILINE)
    return [(name, default.strip(), allowed.strip()) for name, default, allowed in rows]


def is_number(default):
    try:
        float(default)
    except ValueError:
        return False
    return True


class BadParameters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        import rosgraph
        cls.folder = tempfile.TemporaryDirectory()
        cls.suite = Suite(BUILD, Path(cls.folder.name))
        cls.master = rosgraph.Master("/bad_parameters_test")

    @classmethod
    def tearDownClass(cls):
        cls.suite.end()
        cls.folder.cleanup()

    def setUp(self):
        for name in NODES + ["vehicle", "config_file"]:
            if self.master.hasParam("/" + name):
                self.master.deleteParam("/" + name)
        self.master.setParam("/vehicle", {"name": "car"})

    def end_of(self, node):
        """Exit code and log of a node that is expected to end by itself."""
        try:
            done = subprocess.run([self.suite.tools / node, f"__name:={node}"], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True,
                                  timeout=PATIENCE_S)
        except subprocess.TimeoutExpired as ended:
            self.fail(f"{node} started: {(ended.output or b'').decode()[-500:]}")
        return done.returncode, done.stdout

    def expect_all_named(self, node, names):
        code, log = self.end_of(node)
        self.assertEqual(code, 1, f"{node}: {log[-2000:]}")
        self.assertIn("does not start", log)
        missing = [name for name in names if name.replace("/", ".") not in log]
        self.assertEqual(missing, [], f"{node} does not name these: {log[-3000:]}")

    def set_all(self, node, values):
        for name, value in values.items():
            self.master.setParam(f"/{node}/{name}", value)

    def test_values_of_a_wrong_type_are_all_named(self):
        for node in NODES:
            with self.subTest(node):
                values = {name: {"of": ["a wrong", "type"]} for name, _, _ in parameters_of(node)}
                self.set_all(node, values)
                self.expect_all_named(node, values)

    def test_words_for_numbers_are_all_named(self):
        for node in NODES:
            with self.subTest(node):
                values = {name: "many" for name, default, _ in parameters_of(node) if is_number(default)}
                self.set_all(node, values)
                self.expect_all_named(node, values)

    def test_numbers_out_of_range_are_all_named(self):
        for node in NODES:
            for value in (-1e300, 1e300):
                with self.subTest(node=node, value=value):
                    self.setUp()
                    values = {name: value for name, default, allowed in parameters_of(node)
                              if is_number(default) and re.search(
                                  r"[>≥]|to" if value < 0.0 else r"[<≤]|to", allowed)}
                    if values:
                        self.set_all(node, values)
                        self.expect_all_named(node, values)

    def test_numbers_that_are_none_are_all_named(self):
        for node in NODES:
            with self.subTest(node):
                values = {name: math.nan for name, default, _ in parameters_of(node) if is_number(default)}
                self.set_all(node, values)
                self.expect_all_named(node, values)

    def test_vehicle_that_is_none_is_refused(self):
        for node in NODES:
            for vehicle in () if node == "playback" else (7, ["a", "list"], "config/vehicles/no_such_car.yaml", {"length_m": -1.0},
                            {"laser": "in front"}, {"noise": [1.0, 2.0]}):
                with self.subTest(node=node, vehicle=vehicle):
                    self.master.setParam("/vehicle", vehicle)
                    code, log = self.end_of(node)
                    self.assertEqual(code, 1, log)
                    self.assertIn("vehicle", log)

    def test_group_that_is_a_value_is_refused(self):
        for node in NODES:
            for value in (3, "text", [1, 2]):
                with self.subTest(node=node, value=value):
                    self.master.setParam("/" + node, value)
                    code, log = self.end_of(node)
                    self.assertEqual(code, 1, log)
                    self.assertIn("/" + node, log)


if __name__ == "__main__":
    unittest.main(verbosity=1)
