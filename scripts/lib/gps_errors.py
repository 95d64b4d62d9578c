"""Errors of a trajectory against GPS fixes, as doc/results/README.md scores them: written
independently of hymm_evaluate, to check it and to look into single fixes."""

import numpy as np

FASTEST_MPS = 15.0
LONGEST_PAUSE_S = 1.0
JUMP_M = 0.5  # more than a car's position can differ from its trajectory between two fixes


def read_trajectory(path):
    """Rows of time, x, y, yaw from a TUM file."""
    tum = np.loadtxt(path)
    return np.c_[tum[:, :3], np.unwrap(2.0 * np.arctan2(tum[:, 6], tum[:, 7]))]


def read_fixes(path, until_s):
    """Rows of time, east, north, without those that only a faster car could have reached."""
    rows = np.genfromtxt(path, delimiter=",", names=True)
    kept = []
    for fix in np.c_[rows["t"], rows["x"], rows["y"]]:
        if kept and np.hypot(*(fix - kept[-1])[1:]) > FASTEST_MPS * (fix[0] - kept[-1][0]):
            continue
        kept.append(fix)
    kept = np.array(kept)
    return kept[kept[:, 0] < until_s]


def rigid_motion(source, target):
    """Rotation and translation that carry `source` nearest to `target`."""
    a, b = source - source.mean(0), target - target.mean(0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return R, target.mean(0) - R @ source.mean(0)


class GpsErrors:
    """`offsets`: fix minus antenna, as east and north; `forward` and `left`: the same as seen from
    the car."""

    def __init__(self, trajectory, fixes, antenna):
        inside = (fixes[:, 0] >= trajectory[0, 0]) & (fixes[:, 0] <= trajectory[-1, 0])
        self.times, self.fixes = fixes[inside, 0], fixes[inside, 1:]
        x, y, yaw = (np.interp(self.times, trajectory[:, 0], column)
                     for column in trajectory[:, 1:4].T)
        self._antenna = np.c_[x + antenna[0] * np.cos(yaw) - antenna[1] * np.sin(yaw),
                              y + antenna[0] * np.sin(yaw) + antenna[1] * np.cos(yaw)]
        R, translation = rigid_motion(self._antenna, self.fixes)
        self.offsets = self.fixes - self._antenna @ R.T - translation
        heading = yaw + np.arctan2(R[1, 0], R[0, 0])
        self.heading = heading
        c, s = np.cos(heading), np.sin(heading)
        self.forward = c * self.offsets[:, 0] + s * self.offsets[:, 1]
        self.left = -s * self.offsets[:, 0] + c * self.offsets[:, 1]
        self.distances = np.hypot(*self.offsets.T)

    def rmse(self):
        return float(np.sqrt((self.distances ** 2).mean()))

    def median(self):
        return float(np.median(self.distances))

    def jumps(self):
        """Times and sizes of the receiver's jumps: the offset changes between two fixes that follow
        each other at once, while the car goes on smoothly."""
        change = np.hypot(*np.diff(self.offsets, axis=0).T)
        at = (np.diff(self.times) < LONGEST_PAUSE_S) & (change > JUMP_M)
        return self.times[1:][at], change[at]

    def pieces(self):
        """Indices of fixes between pauses and jumps: within a piece errors are much the same, so it
        counts as one observation."""
        change = np.hypot(*np.diff(self.offsets, axis=0).T)
        cut = (np.diff(self.times) >= LONGEST_PAUSE_S) | (change > JUMP_M)
        return np.split(np.arange(len(self.times)), np.nonzero(cut)[0] + 1)

    def standard_error(self, draws=500):
        """Of the RMSE, by drawing pieces with replacement."""
        generator, pieces, values = np.random.default_rng(0), self.pieces(), []
        for _ in range(draws):
            chosen = np.concatenate([pieces[k] for k in generator.integers(0, len(pieces),
                                                                           len(pieces))])
            if len(chosen) < 4:
                continue
            R, t = rigid_motion(self._antenna[chosen], self.fixes[chosen])
            rest = self.fixes[chosen] - self._antenna[chosen] @ R.T - t
            values.append(np.sqrt((rest ** 2).sum(1).mean()))
        return float(np.std(values))
