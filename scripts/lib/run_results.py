"""Reads a folder of results, as hymm_offline and playback.launch output:=DIR leave it."""

import csv
import json
import os

import numpy as np

# As hymm_evaluate: a fix that could only be reached faster is left out.
FASTEST_FIX_MPS = 15.0


class RunResults:
    """What a run left, of its last map: poses before a reset are in another map frame."""

    def __init__(self, folder):
        if not os.path.isdir(folder):
            raise SystemExit(f"{folder}: is not a folder of results.")
        self.folder = folder
        self.summary = self._read_json("summary.json")
        self.events = self._read_csv("events.csv")
        first = max([int(e["scan"]) for e in self.events if e["event"] == "reset"], default=0)
        rows = np.loadtxt(self._path("trajectory.tum"), ndmin=2).reshape(-1, 8)[first:]
        self.times = rows[:, 0]
        self.positions = rows[:, 1:3]
        self.yaws = 2.0 * np.arctan2(rows[:, 6], rows[:, 7])
        self.health = self._read_csv("health.csv")[first:]
        self.landmarks = self._read_csv("landmarks.csv")
        gps = np.array([[float(r["t"]), float(r["x"]), float(r["y"])] for r in self._read_csv("gps.csv")])
        self.fixes = _last_recording(gps.reshape(-1, 3))

    def health_column(self, name):
        return np.array([float(row[name]) for row in self.health])

    def fixes_in_map(self):
        """Reachable GPS fixes in the map frame, after one rigid motion; empty if that is unknown."""
        antenna = self.summary.get("gps_antenna_m")
        fixes = _reachable(self.fixes)
        if len(self.times) == 0 or antenna is None:
            return np.empty((0, 2))
        fixes = fixes[(fixes[:, 0] >= self.times[0]) & (fixes[:, 0] <= self.times[-1])]
        if len(fixes) < 3:
            return np.empty((0, 2))
        return _aligned(fixes[:, 1:], self._antenna_at(fixes[:, 0], antenna))

    def _antenna_at(self, times, antenna):
        x = np.interp(times, self.times, self.positions[:, 0])
        y = np.interp(times, self.times, self.positions[:, 1])
        yaw = np.interp(times, self.times, np.unwrap(self.yaws))
        return np.column_stack([x + np.cos(yaw) * antenna[0] - np.sin(yaw) * antenna[1],
                                y + np.sin(yaw) * antenna[0] + np.cos(yaw) * antenna[1]])

    def _path(self, name):
        path = os.path.join(self.folder, name)
        if not os.path.isfile(path):
            raise SystemExit(f"{path}: is missing; did the run end?")
        return path

    def _read_csv(self, name):
        with open(self._path(name), newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def _read_json(self, name):
        with open(self._path(name), encoding="utf-8") as file:
            return json.load(file)


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
