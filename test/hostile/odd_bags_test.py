#!/usr/bin/python3
"""Bags as they should not be, and as they come all the same: hymm_offline ends with results or with a
sentence, and never by a signal."""
import copy
import json
import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

ROOT = Path(__file__).resolve().parents[2]
TOOLS = Path(os.environ["HYMM_BUILD_DIR"]) / "devel/lib/hymm"
DURATION_S = 30


class OddBags(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)
        subprocess.run([TOOLS / "simulate_world", "--world", "car_park", "--duration", str(DURATION_S),
                        "--output", cls.path / "drive.bag"], check=True, stdout=subprocess.DEVNULL)
        with rosbag.Bag(str(cls.path / "drive.bag")) as bag:
            cls.drive = [(topic, message, time) for topic, message, time in bag
                         if not topic.startswith("/truth")]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def run_on(self, messages, *options):
        """Exit code, what was said, and the summary or None."""
        path = self.path / "odd.bag"
        with rosbag.Bag(str(path), "w") as bag:
            for topic, message, time in messages:
                bag.write(topic, message, time)
        output = self.path / "out"
        (output / "summary.json").unlink(missing_ok=True)
        done = self.run_offline(path, output, *options)
        summary = output / "summary.json"
        self.assertIn(done.returncode, (0, 1), done.stdout)
        return done.returncode, done.stdout, json.loads(summary.read_text()) if summary.exists() else None

    def run_offline(self, bag, output, *options):
        return subprocess.run([TOOLS / "hymm_offline", "--bag", bag, "--config",
                               ROOT / "config/datasets/car_park.yaml", "--output", output, *options],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)

    def stamped(self, change):
        """The drive with `change(index, topic, stamp in s)` as stamps of headers; None leaves one out."""
        messages = []
        for index, (topic, message, time) in enumerate(self.drive):
            if hasattr(message, "header"):
                message = copy.deepcopy(message)
                stamp = change(index, topic, message.header.stamp.to_sec())
                if stamp is None:
                    continue
                message.header.stamp = rospy.Time.from_sec(stamp)
            messages.append((topic, message, time))
        return messages

    def expect_results(self, messages, *options):
        code, said, summary = self.run_on(messages, *options)
        self.assertEqual(code, 0, said)
        self.assertIsNotNone(summary)
        with open(self.path / "out/trajectory.tum") as file:
            for line in file:
                self.assertTrue(all(math.isfinite(float(word)) for word in line.split()), line)
        return summary, said

    def expect_refusal(self, messages, *words, options=()):
        code, said, summary = self.run_on(messages, *options)
        self.assertEqual(code, 1, said)
        self.assertIsNone(summary)
        for word in words:
            self.assertIn(word, said)

    def test_as_it_should_be(self):
        summary, _ = self.expect_results(self.drive)
        self.assertGreater(summary["landmarks"], 10)

    def test_clock_that_runs_back_once_begins_a_new_map(self):
        half = len(self.drive) // 2
        summary, _ = self.expect_results(self.stamped(
            lambda index, topic, s: s if index < half else s - 12.0))
        self.assertEqual(summary["resets"], 1)

    def test_every_message_twice(self):
        once, _ = self.expect_results(self.drive)
        twice, _ = self.expect_results([message for message in self.drive for _ in range(2)])
        self.assertLessEqual(abs(twice["landmarks"] - once["landmarks"]), 3)
        self.assertEqual(twice["resets"], 0)

    def test_stamps_that_are_all_zero(self):
        self.expect_refusal(self.stamped(lambda index, topic, s: 0.0), "stamp")

    def test_one_stamp_in_ten_zero(self):
        summary, _ = self.expect_results(self.stamped(
            lambda index, topic, s: 0.0 if index % 10 == 0 else s))
        self.assertEqual(summary["resets"], 0)
        self.assertGreater(summary["landmarks"], 10)

    def test_stamps_that_are_all_the_same(self):
        code, said, _ = self.run_on(self.stamped(lambda index, topic, s: 5.0))
        if code == 1:
            self.assertIn("time", said)

    def test_stamps_at_the_end_of_time(self):
        self.run_on(self.stamped(lambda index, topic, s: s + 4294967295.0 - 35.0))

    def test_stamps_of_scans_an_hour_ahead(self):
        self.expect_refusal(self.stamped(
            lambda index, topic, s: s + 3600.0 if topic.strip("/") == "scan" else s), "not of one time")

    def scans(self):
        return sum(topic.strip("/") == "scan" for topic, _, _ in self.drive)

    def expect_scans_but(self, dropped, change, more_landmarks_than=10):
        summary, said = self.expect_results(self.stamped(change))
        self.assertEqual(summary["dropped_scans"], dropped, said)
        self.assertEqual(summary["scans"], self.scans() - dropped, said)
        self.assertEqual(summary["resets"], 0, said)
        self.assertGreater(summary["landmarks"], more_landmarks_than)

    def one_ahead(self, name, at_s, by_s):
        """Of the messages on a topic, the first after `at_s` of the drive has its stamp `by_s` too late."""
        begin = self.drive[0][2].to_sec()
        chosen = next(i for i, (topic, _, time) in enumerate(self.drive)
                      if topic.strip("/") == name and time.to_sec() > begin + at_s)
        return lambda index, topic, s: s + by_s if index == chosen else s

    def test_gps_clock_ahead_takes_no_scan(self):
        self.assertTrue(any(topic.strip("/") == "gps/fix" for topic, _, _ in self.drive))
        for by_s in (5.0, 3600.0):
            with self.subTest(by_s=by_s):
                self.expect_scans_but(0, lambda index, topic, s: s + by_s if topic.strip("/") == "gps/fix" else s)

    def test_one_scan_ahead_is_the_one_that_is_dropped(self):
        self.expect_scans_but(1, self.one_ahead("scan", 15.0, 100.0))

    def test_one_motion_input_ahead_takes_no_scan(self):
        self.expect_scans_but(0, self.one_ahead("dead_reckoning", 15.0, 100.0))

    def test_gap_of_an_hour_in_all_stamps_takes_no_scan(self):
        half = len(self.drive) // 2
        # Nothing is mapped after it until the place is known: the drive does not come back.
        self.expect_scans_but(0, lambda index, topic, s: s if index < half else s + 3600.0,
                              more_landmarks_than=5)

    def test_stamps_in_random_order_within_half_a_second(self):
        import random
        draw = random.Random(1)
        summary, _ = self.expect_results(sorted(
            self.drive, key=lambda entry: entry[2].to_sec() + draw.uniform(0.0, 0.5)))
        self.assertGreater(summary["landmarks"], 5)

    def test_two_vehicles_on_one_topic(self):
        others = []
        for topic, message, time in self.drive:
            message = copy.deepcopy(message)
            if hasattr(message, "header") and topic.strip("/") == "scan":
                message.header.frame_id = "other/laser"
                others.append((topic, message, time + rospy.Duration(0.001)))
        summary, said = self.expect_results(sorted(self.drive + others, key=lambda entry: entry[2].to_sec()))
        self.assertIn("other/laser", said)
        self.assertGreater(summary["landmarks"], 10)

    def test_transforms_in_a_circle(self):
        circle = TFMessage([TransformStamped(), TransformStamped()])
        for transform, parent, child in zip(circle.transforms, ("base_link", "laser"), ("laser", "base_link")):
            transform.header.frame_id, transform.child_frame_id = parent, child
            transform.header.stamp = rospy.Time(1)
            transform.transform.rotation.w = 1.0
        self.run_on([entry for entry in self.drive if "tf" not in entry[0]] +
                    [("/tf_static", circle, self.drive[0][2])])

    def test_gps_alone(self):
        self.expect_refusal([entry for entry in self.drive if "gps" in entry[0]], "scan", "gps/fix")

    def test_scans_alone(self):
        self.expect_refusal([entry for entry in self.drive if entry[0].strip("/") == "scan"], "dead_reckoning")

    def test_one_scan(self):
        first = next(i for i, entry in enumerate(self.drive) if entry[0].strip("/") == "scan")
        self.run_on(self.drive[:first + 1])

    def test_scans_without_a_beam(self):
        def emptied(message):
            message = copy.deepcopy(message)
            message.ranges, message.intensities = [], []
            return message
        self.run_on([(topic, emptied(m) if topic.strip("/") == "scan" else m, time)
                     for topic, m, time in self.drive])

    def test_scans_that_change_their_size(self):
        def cut(message, index):
            message = copy.deepcopy(message)
            message.ranges = message.ranges[:index % 300]
            return message
        self.run_on([(topic, cut(m, i) if topic.strip("/") == "scan" else m, time)
                     for i, (topic, m, time) in enumerate(self.drive)])

    def test_scans_of_numbers_that_are_none(self):
        def spoiled(message):
            message = copy.deepcopy(message)
            message.ranges = [math.nan] * len(message.ranges)
            return message
        summary, _ = self.expect_results([(topic, spoiled(m) if topic.strip("/") == "scan" else m, time)
                                          for topic, m, time in self.drive])
        self.assertEqual(summary["landmarks"], 0)

    def test_gps_of_another_type_is_needed_only_where_it_is_asked_for(self):
        odd = [(topic, String("no fix"), time) if topic.strip("/") == "gps/fix" else (topic, message, time)
               for topic, message, time in self.drive]
        count = sum(topic.strip("/") == "gps/fix" for topic, _, _ in self.drive)
        self.assertGreater(count, 0)
        summary, _ = self.expect_results(odd)
        self.assertIn("messages of /gps/fix left out: it holds std_msgs/String, not "
                      f"sensor_msgs/NavSatFix: {count}", summary["notes"])
        self.assertEqual(summary["gps_fixes"], 0)
        self.expect_refusal(odd, "std_msgs/String", options=["--topic", "gps/fix:=/gps/fix"])
        fused = self.path / "fused.yaml"
        fused.write_text("cekf_slam: {gps: {enabled: true}}\n")
        self.expect_refusal(odd, "std_msgs/String", options=["--config", fused])

    def transform(self, time, parent, child, x=0.0):
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = parent, child
        transform.header.stamp = time
        transform.transform.translation.x = x
        transform.transform.rotation.w = 1.0
        return transform

    def test_transforms_that_cannot_be_used_are_left_out(self):
        plain, _ = self.expect_results(self.drive)
        time = self.drive[len(self.drive) // 10][2]
        bad = [self.transform(rospy.Time(4294967295), "base_link", "roof"),
               self.transform(time, "base_link", "nose", math.nan), self.transform(time, "mast", "mast")]
        index = len(self.drive) // 10
        summary, _ = self.expect_results(self.drive[:index] + [("/tf", TFMessage(bad), time)] + self.drive[index:])
        for problem in ("its stamp is at the end of time", "it is not finite", "its two frames are the same"):
            self.assertIn(f"transforms refused: {problem}: 1", summary["notes"])
        self.assertEqual(summary["landmarks"], plain["landmarks"])

    def with_laser_told_late(self, keep_tf):
        """The laser's place comes 12 s late, 1 m from where the vehicle's description has it."""
        begin = self.drive[0][2]
        laser = self.frame_of_scans()
        messages = [entry for entry in self.drive
                    if "tf" not in entry[0] or keep_tf and entry[0].strip("/") == "tf"]
        for after_s in range(12, DURATION_S):
            time = begin + rospy.Duration(after_s)
            messages.append(("/tf", TFMessage([self.transform(time, "base_link", laser, self.place_of_laser() + 1.0)]),
                             time))
        return sorted(messages, key=lambda entry: entry[2].to_sec())

    def frame_of_scans(self):
        return next(m.header.frame_id for topic, m, _ in self.drive if topic.strip("/") == "scan")

    def place_of_laser(self):
        transforms = [transform for topic, message, _ in self.drive if "tf_static" in topic
                      for transform in message.transforms]
        return next(t.transform.translation.x for t in transforms if t.child_frame_id == self.frame_of_scans())

    def test_laser_whose_place_is_told_late(self):
        described, _ = self.expect_results([entry for entry in self.drive if "tf" not in entry[0]])
        words = f"scans or detections of frame '{self.frame_of_scans()}' placed as the vehicle's description says: "
        self.assertIn(words + str(described["scans"]), described["notes"])
        there = (self.path / "out" / "trajectory.tum").read_bytes()
        for keep_tf in (False, True):
            summary, _ = self.expect_results(self.with_laser_told_late(keep_tf))
            self.assertNotIn("description", " ".join(summary["notes"]))
            self.assertNotEqual((self.path / "out" / "trajectory.tum").read_bytes(), there)

    def contents(self, folder):
        """Of all files in it, by name."""
        return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}

    def test_bag_that_is_not_there_costs_no_results(self):
        output = self.path / "earlier"
        self.assertEqual(self.run_offline(self.path / "drive.bag", output).returncode, 0)
        before = self.contents(output)
        done = self.run_offline(self.path / "nosuch.bag", output)
        self.assertEqual(done.returncode, 1)
        self.assertIn("nosuch.bag: there is no such file", done.stdout)
        self.assertEqual(self.contents(output), before)

    def test_bag_without_a_usable_scan_costs_no_results(self):
        output = self.path / "out"
        self.expect_results(self.drive)
        before = self.contents(output)
        del before["summary.json"]  # run_on() removes it
        self.expect_refusal(self.stamped(lambda index, topic, s: 0.0), "stamp")
        self.assertEqual(self.contents(output), before)

    def test_folder_holds_the_last_run_only(self):
        output, alone = self.path / "both", self.path / "alone"
        all_files = self.path / "all.yaml"
        all_files.write_text("door_planner: {goal: 5 0, check_queries: 3}\n")
        everything = self.run_offline(self.path / "drive.bag", output, "--config", all_files, "--observations")
        self.assertEqual(everything.returncode, 0, everything.stdout)
        for name in ("map.pgm", "ltrs.csv", "plan.csv", "plan_queries.csv", "observations.csv"):
            self.assertTrue((output / name).exists(), name)
        (output / "notes.txt").write_text("of the user")
        for folder in (output, alone):
            done = self.run_offline(self.path / "drive.bag", folder, "--only", "cekf_slam")
            self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual({path.name for path in output.iterdir()},
                         {path.name for path in alone.iterdir()} | {"notes.txt"})

    def test_map_folder_that_cannot_be_used_is_told_before_the_run(self):
        output, used = self.path / "saving", self.path / "used"
        used.mkdir()
        (used / "notes.txt").write_text("of the user")
        for folder, words in ((output, "the same folder"), (used, "notes.txt"),
                              (self.path / "no" / "such" / "folder", "cannot be made")):
            done = self.run_offline(self.path / "drive.bag", output, "--save", folder)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn(words, done.stdout)
            self.assertEqual(list(output.iterdir()), [])

    def test_map_is_saved_below_the_results(self):
        output = self.path / "with_map"
        for _ in range(2):
            done = self.run_offline(self.path / "drive.bag", output, "--save", output / "map")
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertTrue((output / "map" / "map.txt").exists())
            self.assertTrue((output / "summary.json").exists())


if __name__ == "__main__":
    unittest.main(verbosity=1)
