"""Reads a folder of results, as hymm_offline and playback.launch output:=DIR leave it."""

import csv
import json
import os
from functools import cached_property

import numpy as np

# As hymm_evaluate: a fix that could only be reached faster is left out.
FASTEST_FIX_MPS = 15.0


class Lacks(Exception):
    """What a run does not hold, as a sentence for people."""


class RunResults:
    """What a run left, of its last map: poses before a reset are in another map frame. What is asked for is read then;
    where the run does not hold it, that raises Lacks."""

    def __init__(self, folder):
        if not os.path.isdir(folder):
            raise SystemExit(f"{folder}: is not a folder of results.")
        self.folder = folder

    @cached_property
    def summary(self):
        with open(self._path("summary.json", "did the run end?"), encoding="utf-8") as file:
            try:
                return json.load(file)
            except ValueError as error:
                raise Lacks(f"summary.json cannot be read: {error}.") from error

    @cached_property
    def events(self):
        return self._read_csv("events.csv")

    @cached_property
    def health(self):
        """Lines of health.csv."""
        return self._filled("health.csv", "no scan was used.")[self._first_scan():]

    def health_column(self, name):
        return self._numbers("health.csv", self.health, name)

    @cached_property
    def poses(self):
        """Of base_link in map: time, x, y, yaw of each scan."""
        path = self._path("trajectory.tum")
        try:
            with open(path, encoding="utf-8") as file:
                rows = [[float(word) for word in line.split()] for line in file if line.strip()]
            rows = np.array(rows, dtype=float).reshape(-1, 8)[self._first_scan():]
        except ValueError as error:
            raise Lacks(f"trajectory.tum cannot be read: {error}.") from error
        if not len(rows):
            raise Lacks("trajectory.tum is empty: no scan was used.")
        return np.column_stack([rows[:, :3], 2.0 * np.arctan2(rows[:, 6], rows[:, 7])])

    @cached_property
    def landmarks(self):
        return self._read_csv("landmarks.csv")

    def places(self):
        """Of the landmarks, by id."""
        rows = self.landmarks
        x, y = (self._numbers("landmarks.csv", rows, name) for name in ("x", "y"))
        return {int(row["id"]): (px, py) for row, px, py in zip(rows, x, y)}

    @cached_property
    def ltrs(self):
        """Landmark ids of the corners, three a row."""
        return self._vertices("ltrs.csv", self._filled(
            "ltrs.csv", "landmarks spanned no triangle.", "hymm_grid did not run."))

    @cached_property
    def level_sets(self):
        """Leaves of the level sets: value, x, y, edge, island."""
        rows = self._filled("level_sets.csv", "nowhere do landmarks give so much information.",
                            "information_map did not run.")
        return np.column_stack([self._numbers("level_sets.csv", rows, name)
                                for name in ("value", "x", "y", "edge", "island")])

    @cached_property
    def doors(self):
        """Lines of doors.csv, one a portal."""
        return self._read_csv("doors.csv", "nothing was planned.")

    def portals_among(self, places):
        """x, y of the portals where landmarks are at `places`: each keeps its share of its LTRs' side."""
        now, portals = self.places(), []
        for row in self.doors:
            ids = int(row["landmark_1"]), int(row["landmark_2"])
            if any(i not in now or i not in places for i in ids):
                continue
            (begin, end), (moved_begin, moved_end) = np.array([[known[i] for i in ids] for known in (now, places)])
            along = end - begin
            share = np.dot([float(row["x"]) - begin[0], float(row["y"]) - begin[1]], along) / np.dot(along, along)
            portals.append(moved_begin + share * (moved_end - moved_begin))
        return np.array(portals).reshape(-1, 2)

    @cached_property
    def plan(self):
        """Lines of plan.csv."""
        return self._filled("plan.csv", "no way was found; the notes of the summary say why.",
                            "no path was planned; hymm_offline plans one to `door_planner: {goal: \"X Y\"}`.")

    def path_among(self, places):
        """The plan where landmarks are at `places`: by its weights alone, which move it with them."""
        rows = self.plan
        weights = np.column_stack([self._numbers("plan.csv", rows, f"weight_{k}") for k in (1, 2, 3)])
        corners = self._vertices("plan.csv", rows)
        if any(i not in places for i in corners.flat):
            raise Lacks("plan.csv names landmarks that landmarks.csv does not hold.")
        return np.array([[sum(w * places[i][k] for w, i in zip(*point)) for k in (0, 1)]
                         for point in zip(weights, corners)])

    @cached_property
    def exploration(self):
        """Suggested goals: x, y."""
        rows = self._filled("exploration.csv", "no goal can be reached.")
        return np.column_stack([self._numbers("exploration.csv", rows, name) for name in ("x", "y")])

    @cached_property
    def occupancy(self):
        """Picture of the occupancy, 0 black to 255 white, upper row first, and its extent in map."""
        from PIL import Image

        try:
            with open(self._path("map.yaml", "nothing was mapped."), encoding="utf-8") as file:
                entries = dict(line.split(":", 1) for line in file if ":" in line)
            resolution = float(entries["resolution"])
            low = [float(word) for word in entries["origin"].strip(" []\n").split(",")[:2]]
            with Image.open(self._path("map.pgm", "nothing was mapped.")) as picture:
                pixels = np.array(picture)
        except (KeyError, ValueError, OSError) as error:
            raise Lacks(f"map.pgm and map.yaml cannot be read: {error}.") from error
        height, width = pixels.shape[:2]
        return pixels, (low[0], low[0] + width * resolution, low[1], low[1] + height * resolution)

    def fixes_in_map(self):
        """Reachable GPS fixes in the map frame, after one rigid motion; Lacks where that is unknown."""
        antenna = self.summary.get("gps_antenna_m")
        rows = self._filled("gps.csv", "the run had no GPS fixes.")
        gps = np.column_stack([self._numbers("gps.csv", rows, name) for name in ("t", "x", "y")])
        fixes = _reachable(_last_recording(gps))
        fixes = fixes[(fixes[:, 0] >= self.poses[0, 0]) & (fixes[:, 0] <= self.poses[-1, 0])]
        if antenna is None or len(fixes) < 3:
            raise Lacks("gps.csv holds fewer than three fixes that can be compared.")
        return _aligned(fixes[:, 1:], self._antenna_at(fixes[:, 0], antenna))

    def _antenna_at(self, times, antenna):
        x, y, yaw = (np.interp(times, self.poses[:, 0], column)
                     for column in (self.poses[:, 1], self.poses[:, 2], np.unwrap(self.poses[:, 3])))
        return np.column_stack([x + np.cos(yaw) * antenna[0] - np.sin(yaw) * antenna[1],
                                y + np.sin(yaw) * antenna[0] + np.cos(yaw) * antenna[1]])

    def _first_scan(self):
        """Of the last map."""
        try:
            resets = [row for row in self.events if row.get("event") == "reset"]
            return int(resets[-1]["scan"]) if resets else 0
        except (Lacks, KeyError, ValueError):
            return 0

    def _path(self, name, hint=""):
        path = os.path.join(self.folder, name)
        if not os.path.isfile(path):
            raise Lacks(f"{name} is missing" + (f": {hint}" if hint else "."))
        return path

    def _read_csv(self, name, hint=""):
        try:
            with open(self._path(name, hint), newline="", encoding="utf-8") as file:
                return list(csv.DictReader(file))
        except (csv.Error, UnicodeDecodeError) as error:
            raise Lacks(f"{name} cannot be read: {error}.") from error

    def _filled(self, name, why_empty, why_missing=""):
        rows = self._read_csv(name, why_missing)
        if not rows:
            raise Lacks(f"{name} is empty: {why_empty}")
        return rows

    @staticmethod
    def _numbers(name, rows, column):
        try:
            return np.array([float(row[column]) for row in rows])
        except (KeyError, TypeError, ValueError) as error:
            raise Lacks(f"{name} cannot be read: column {column} is not all numbers ({error}).") from error

    @classmethod
    def _vertices(cls, name, rows):
        return np.column_stack([cls._numbers(name, rows, f"landmark_{k}") for k in (1, 2, 3)]).astype(int)


def _last_recording(fixes):
    steps_back = np.flatnonzero(np.diff(fixes[:, 0]) < 0)
    return fixes[steps_back[-1] + 1:] if len(steps_back) else fixes


def _reachable(fixes):
    kept = []
    for fix in fixes:
        if kept:
            distance = np.hypot(*(fix[1:] - kept[-1][1:]))
            if not distance <= FASTEST_FIX_MPS * (fix[0] - kept[-1][0]):
                continue
        kept.append(fix)
    return np.array(kept).reshape(-1, 3)


def _aligned(points, targets):
    """`points` moved by the rotation and translation that bring them nearest to `targets`."""
    p, q = points - points.mean(axis=0), targets - targets.mean(axis=0)
    angle = np.arctan2((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum(), (p * q).sum())
    c, s = np.cos(angle), np.sin(angle)
    return p @ np.array([[c, s], [-s, c]]) + targets.mean(axis=0)
