#!/usr/bin/python3
"""Ctrl-C while a large map is saved by the live nodes: each of them ends by itself, and the folder holds
the map before or the new one, whole. Kills are the affair of scripts/experiments/reliability."""
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/lib"))
from hostile_suite import Suite, wait_for  # noqa: E402
from map_check import OVERLAY, MapCheck  # noqa: E402

BUILD = Path(os.environ["HYMM_BUILD_DIR"])
LANDMARKS = 400  # their covariance is what takes long to write
NODES = ["cekf_slam", "hymm_grid", "supervisor"]
PATIENCE_S = 120.0
POLL_S = 0.0005


class Folder:
    """What a save has reached, by the files that are there."""

    def __init__(self, path):
        self.path = path
        self.before = set(os.listdir(path))
        self.text = (path / "map.txt").read_bytes()

    def has_begun(self, part):
        return (self.path / f"{part}.active").exists()

    def is_half_written(self, part):
        """As long as half of the part in the map before."""
        old = next(file for file in self.before if file.startswith(part))
        try:
            return (self.path / f"{part}.active").stat().st_size > (self.path / old).stat().st_size // 2
        except FileNotFoundError:
            return False

    def has_new(self, part):
        return any(file.startswith(f"{part}-") for file in set(os.listdir(self.path)) - self.before)

    def is_replaced(self):
        return (self.path / "map.txt").read_bytes() != self.text


# One save is seen to pass some of these; which, its speed decides. The end of the save counts as each.
MOMENTS = {
    "at once": lambda folder: True,
    "landmarks begun": lambda folder: folder.has_begun("landmarks"),
    "landmarks half written": lambda folder: folder.is_half_written("landmarks"),
    "landmarks written": lambda folder: folder.has_new("landmarks"),
    "dense map begun": lambda folder: folder.has_begun("dense_map"),
    "dense map written": lambda folder: folder.has_new("dense_map"),
    "map replaced": Folder.is_replaced,
}
VICTIMS = [["cekf_slam"], ["hymm_grid"], ["supervisor"], NODES]


class InterruptedSaves(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.work = Path(cls.temporary.name)
        cls.suite = Suite(BUILD, cls.work)
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.addClassCleanup(cls.suite.end)
        cls.make_map()
        cls.map_check = MapCheck(cls.suite.tools, cls.work)
        cls.suite.configure(OVERLAY)
        import rospy
        rospy.init_node("interrupted_saves_test", disable_signals=True)

    @classmethod
    def make_map(cls):
        bag, trunks = cls.work / "drive.bag", cls.work / "trunks.yaml"
        trunks.write_text("vehicle: simulated_car\n")
        for command in (
                ["simulate_world", "--world", "plain", "--landmarks", LANDMARKS, "--laps", 1, "--output", bag],
                ["hymm_offline", "--bag", bag, "--config", trunks, "--only", "cekf_slam,hymm_grid", "--save",
                 cls.work / "large", "--output", cls.work / "made"]):
            subprocess.run([str(word) for word in [cls.suite.tools / command[0], *command[1:]]], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        bag.unlink()

    def load_live(self):
        """Starts what does not run, with the large map in it."""
        import rospy
        from hymm.srv import LoadMap
        self.suite.start(*[name for name in NODES if name not in self.suite.running])
        told = []

        def is_loaded():
            try:
                answer = rospy.ServiceProxy("load_map", LoadMap)(path=str(self.work / "large"))
            except rospy.ServiceException as problem:
                told.append(str(problem))
                return False
            told.append(answer.message)
            return answer.success and answer.ltrs > 0  # with hymm_grid, if that is there already

        self.assertTrue(wait_for(is_loaded, PATIENCE_S), told[-1:])

    def save_live(self, path, answers):
        import rospy
        from hymm.srv import SaveMap
        try:
            answers.append(rospy.ServiceProxy("save_map", SaveMap)(path=str(path)))
        except rospy.ServiceException as problem:
            answers.append(problem)  # the supervisor has ended

    def interrupt_at(self, moment, victims, path):
        """Answer of the save, and seconds that the victims took to end."""
        folder, answers = Folder(path), []
        saving = threading.Thread(target=self.save_live, args=(path, answers), daemon=True)
        saving.start()
        while saving.is_alive() and not MOMENTS[moment](folder):
            time.sleep(POLL_S)
        reached = saving.is_alive()
        took_s = self.suite.interrupt(*victims)
        saving.join(PATIENCE_S)
        self.assertFalse(saving.is_alive(), "save_map does not answer")
        answer = answers[0]
        self.assertEqual(self.suite.note_crashes(), [])
        self.assertTrue(folder.is_replaced() or not getattr(answer, "success", False),
                        "told to be saved, and is not")
        return reached, took_s

    def test_each_node_at_each_moment(self):
        path = self.work / "map"
        shutil.copytree(self.work / "large", path)
        slowest_s, reached = 0.0, {}
        for number, moment in enumerate(MOMENTS):
            victims = VICTIMS[number % len(VICTIMS)]
            with self.subTest(moment=moment, victims=victims):
                self.load_live()
                reached[moment], took_s = self.interrupt_at(moment, victims, path)
                slowest_s = max(slowest_s, took_s)
                self.assertEqual(self.map_check.problem_of(path), "")
        print(f"slowest end: {slowest_s:.2f} s; moments met within a save: "
              f"{sum(reached.values())} of {len(reached)}", flush=True)
        self.load_live()
        answers = []
        self.save_live(path, answers)
        self.assertTrue(getattr(answers[0], "success", False), answers)
        self.assertEqual(len(os.listdir(path)), 3, "what interrupted saves left is removed")


if __name__ == "__main__":
    unittest.main(verbosity=1, warnings="ignore")  # of sockets that rospy leaves open
