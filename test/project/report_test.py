#!/usr/bin/python3
"""scripts/report makes one self-contained page of any run, and says in a sentence what the run lacks."""

import json
import os
import re
import subprocess
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PICTURES = 6  # trajectory, dense map, level sets, plan, health, latency


class Page(HTMLParser):
    """Sources of pictures, texts, and whether every element is closed."""

    VOID = {"meta", "img"}

    def __init__(self, text):
        super().__init__()
        self.sources, self.open, self.words = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.sources += [value for name, value in attrs if name in ("src", "href")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words += data


def write_run(folder):
    """A short drive past five landmarks, with everything that a run can leave."""
    places = [(0, 5), (10, 5), (20, 5), (5, -5), (15, -5)]
    files = {
        "trajectory.tum": "".join(f"{k * 0.2:g} {k:g} 0 0 0 0 0 1\n" for k in range(40)),
        "landmarks.csv": "id,type,x,y,cxx,cxy,cyy,diameter,observations\n" + "".join(
            f"{i},trunk,{x},{y},0.01,0.001,0.02,0.4,9\n" for i, (x, y) in enumerate(places)),
        "health.csv": "t,nis,dof,ambiguity,unexplained,missed,latency_ms,mode\n" + "".join(
            f"{k * 0.2:g},4,4,0,0.1,0,0.{k + 1},{'CEKF' if k < 30 else 'RELOCALISING'}\n" for k in range(40)),
        "gps.csv": "t,x,y,cxx,cxy,cyy\n" + "".join(f"{k},{5 * k + 3},7,1,0,1\n" for k in range(8)),
        "events.csv": "t,scan,event,mode,reason\n6,30,mode_switch,RELOCALISING,two <trees> & a post\n",
        "ltrs.csv": "id,landmark_1,landmark_2,landmark_3\n0,0,3,1\n1,1,4,2\n",
        "level_sets.csv": "value,x,y,edge,island\n25,8,0,8,0\n25,13,0,2,0\n100,8,0,4,1\n",
        "doors.csv": "x,y,door,landmark_1,landmark_2\n8,2,0,1,3\n",
        "plan.csv": "x,y,landmark_1,landmark_2,landmark_3,weight_1,weight_2,weight_3\n"
                    "5,1,0,3,1,0.3,0.4,0.3\n10,1,1,4,2,0.4,0.4,0.2\n",
        "exploration.csv": "x,y\n12,2\n",
        "map.yaml": "image: map.pgm\nresolution: 0.5\norigin: [-2.0, -10.0, 0.0]\n",
        "map.pgm": "P2\n60 40\n255\n" + "254 " * 2300 + "0 " * 50 + "205 " * 50,
        "summary.json": json.dumps({"scans": 40, "duration_s": 8.0, "landmarks": 5, "gps_rmse_m": None,
                                    "gps_antenna_m": [0.0, 0.0], "notes": ["a <note>"]}),
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    return list(files)


class ReportTest(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def run_report(self, folder=None):
        return subprocess.run([ROOT / "scripts/report", folder or self.folder], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, check=False,
                              env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})

    def page(self):
        done = self.run_report()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.strip(), str(self.folder / "report.html"))
        page = Page((self.folder / "report.html").read_text())
        self.assertEqual(page.open, [])
        for source in page.sources:
            self.assertRegex(source, "^data:image/png;base64,")  # nothing from outside
        return page

    def test_a_whole_run_is_shown(self):
        write_run(self.folder)
        page = self.page()
        self.assertEqual(len(page.sources), PICTURES)
        self.assertNotRegex(page.words, "missing|empty|cannot be read")
        self.assertIn("two <trees> & a post", page.words)  # as text, not as an element
        self.assertIn("a <note>", page.words)

    def test_a_run_that_left_nothing_is_told_file_by_file(self):
        page = self.page()
        self.assertEqual(page.sources, [])
        self.assertIn("summary.json is missing: did the run end?", page.words)
        for name in ("trajectory.tum", "ltrs.csv", "level_sets.csv", "plan.csv", "health.csv", "events.csv"):
            self.assertIn(f"{name} is missing", page.words)

    def test_a_run_of_the_filter_alone_says_what_did_not_run(self):
        for name in write_run(self.folder):
            if name in ("ltrs.csv", "level_sets.csv", "plan.csv", "doors.csv", "map.pgm", "gps.csv"):
                (self.folder / name).unlink()
        page = self.page()
        self.assertEqual(len(page.sources), PICTURES - 3)
        self.assertIn("ltrs.csv is missing", page.words)
        self.assertIn("no path was planned", page.words)

    def test_files_without_content_or_with_rubbish_are_told(self):
        for name in write_run(self.folder):
            path = self.folder / name
            header = path.read_text().splitlines()[0]
            path.write_text(header + "\n" + ("" if name in ("plan.csv", "health.csv") else "rubbish,\x01,{\n"))
        page = self.page()
        self.assertEqual(page.sources, [])
        self.assertIn("plan.csv is empty: no way was found", page.words)
        self.assertIn("health.csv is empty: no scan was used", page.words)
        self.assertIn("trajectory.tum cannot be read", page.words)
        self.assertIn("level_sets.csv cannot be read", page.words)

    def test_a_page_that_is_being_read_stays_whole(self):
        self.page()
        with open(self.folder / "report.html", "rb", buffering=0) as reader:
            begin = reader.read(50)
            write_run(self.folder)
            self.page()
            before = (begin + reader.read()).decode()
        self.assertIn("summary.json is missing", before)
        self.assertEqual(before[-8:], "</html>\n")
        self.assertNotIn("summary.json is missing", (self.folder / "report.html").read_text())

    def test_what_is_no_folder_is_refused(self):
        done = self.run_report(self.folder / "none")
        self.assertNotEqual(done.returncode, 0)
        self.assertTrue(re.search("none: is not a folder of results", done.stderr), done.stderr)


if __name__ == "__main__":
    unittest.main()
