#!/usr/bin/python3
"""Saved maps with any file cut off, changed or missing, and places that cannot be written:
hymm_offline tells in a sentence what is wrong, and leaves what was saved before as it was."""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOLS = Path(os.environ["HYMM_BUILD_DIR"]) / "devel/lib/hymm"


class SpoiledMaps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)
        subprocess.run([TOOLS / "simulate_world", "--world", "car_park", "--duration", "10", "--output",
                        cls.path / "drive.bag"], check=True, stdout=subprocess.DEVNULL)
        done = cls.run_offline("--save", cls.path / "map")
        assert done.returncode == 0, done.stdout

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def run_offline(cls, *arguments):
        return subprocess.run([TOOLS / "hymm_offline", "--bag", cls.path / "drive.bag", "--config",
                               ROOT / "config/datasets/car_park.yaml", "--only", "cekf_slam,hymm_grid",
                               "--output", cls.path / "out", *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)

    def spoiled(self, name, spoil):
        """A copy of the map with one file spoilt."""
        copy = self.path / "spoiled"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(self.path / "map", copy)
        spoil(copy / name)
        return copy

    def expect_refusal(self, name, spoil, what):
        copy = self.spoiled(name, spoil)
        before = {file.name: file.read_bytes() for file in copy.iterdir()}
        done = self.run_offline("--load", copy)
        self.assertEqual(done.returncode, 1, f"{name} {what}: {done.stdout}")
        self.assertIn("spoiled", done.stdout)
        self.assertEqual(before, {file.name: file.read_bytes() for file in copy.iterdir()})

    def test_whole_map_is_loaded(self):
        done = self.run_offline("--load", self.path / "map")
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_any_file_cut_off(self):
        for file in (self.path / "map").iterdir():
            size = file.stat().st_size
            for kept in (0, 1, size // 2, size - 1):
                self.expect_refusal(file.name, lambda path: os.truncate(path, kept), f"cut at {kept}")

    def test_any_file_longer(self):
        for file in (self.path / "map").iterdir():
            self.expect_refusal(file.name, lambda path: path.write_bytes(path.read_bytes() + b"\n"), "longer")

    def test_any_file_with_a_bit_wrong(self):
        for file in (self.path / "map").iterdir():
            size = file.stat().st_size
            for at in range(0, size, max(1, size // 12)):
                def flip(path):
                    content = bytearray(path.read_bytes())
                    content[at] ^= 0x10
                    path.write_bytes(bytes(content))
                self.expect_refusal(file.name, flip, f"changed at {at}")

    def test_any_file_missing(self):
        for file in (self.path / "map").iterdir():
            self.expect_refusal(file.name, lambda path: path.unlink(), "missing")

    def test_folder_in_the_place_of_a_file(self):
        for file in (self.path / "map").iterdir():
            copy = self.spoiled(file.name, lambda path: path.unlink())
            (copy / file.name).mkdir()
            done = self.run_offline("--load", copy)
            self.assertEqual(done.returncode, 1, done.stdout)

    def test_places_that_cannot_be_written(self):
        (self.path / "a_file").write_text("")
        taken = self.path / "taken"
        taken.mkdir(exist_ok=True)
        (taken / "photo.jpg").write_text("not a map")
        for place in (self.path / "a_file", self.path / "no/such/parent", Path("/proc/map"), taken,
                      Path("/dev/full"), self.path / ("x" * 300)):
            done = self.run_offline("--save", place)
            self.assertEqual(done.returncode, 1, f"{place}: {done.stdout}")
            self.assertIn(place.name[:20], done.stdout)
        self.assertEqual((taken / "photo.jpg").read_text(), "not a map")


if __name__ == "__main__":
    unittest.main(verbosity=1)
