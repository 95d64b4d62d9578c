"""Least squares over a whole drive of an Ackermann car: all poses, landmarks, motion errors and
calibration at once, with the associations that the filter made. An independent reference for the
filter (it shares none of its code), and a source of noise parameters: the variance components say
how large each kind of error really was.

Model: scan k+1 is where the encoders lead from scan k; speed and steering have first-order
Gauss-Markov errors e (in units of their deviations; of steering, one that is constant and one that is
relative to the angle), side slip is white; an observation is range and
bearing from the laser at the stamp plus a time offset. A gross error counts less (Cauchy weights)."""

import numpy as np
import rosbag
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

# Calibration: nominal value and deviation of the prior.
PRIORS = {"speed_scale": (1.0, 0.02), "steering_scale": (1.0, 0.05), "steering_offset_rad": (0.0, 0.01),
          "laser_yaw_rad": (0.0, 0.02), "range_offset_m": (0.0, 0.1), "time_offset_s": (0.0, 0.1),
          "range_scale": (0.0, 0.02)}
USUAL = ("speed_scale", "steering_scale", "steering_offset_rad", "laser_yaw_rad", "range_offset_m",
         "time_offset_s")
CAR = {"wheelbase": 2.83, "encoder_left": 0.76, "laser": (3.78, 0.5)}
CAUCHY = 6.0
ERRORS = ("speed_error", "steering_error", "steering_relative_error")
STATES = 3 + len(ERRORS)  # of a scan: x, y, yaw, errors


def read_motion(bag):
    """Rows of time, speed, steering."""
    with rosbag.Bag(str(bag)) as messages:
        return np.array([(m.header.stamp.to_sec(), m.speed, m.steering)
                         for _, m, _ in messages.read_messages(topics=["dead_reckoning",
                                                                       "/dead_reckoning"])])


def wrapped(angle):
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


class Rows:
    """Collects rows of a sparse Jacobian and of residuals, both already divided by deviations."""

    def __init__(self):
        self._entries, self._residuals, self._count = [], [], 0

    def add(self, residuals, columns_and_values):
        rows = self._count + np.arange(len(residuals))
        for columns, values in columns_and_values:
            values = np.broadcast_to(values, rows.shape)
            self._entries.append((rows, np.broadcast_to(columns, rows.shape), values))
        self._residuals.append(residuals)
        self._count += len(residuals)
        return rows

    def matrix(self, width):
        rows, columns, values = (np.concatenate(part) for part in zip(*self._entries))
        return sparse.csr_matrix((values, (rows, columns)), shape=(self._count, width))

    def residuals(self):
        return np.concatenate(self._residuals)


class BatchSolution:
    """`trajectory`: rows of time, x, y, yaw at the scans, to start from. `observations`: the columns of
    observations.csv, associated ones only. `noise`: deviations with the names of the vehicle's
    configuration."""

    def __init__(self, motion, trajectory, observations, noise, calibration=USUAL, robust=True):
        self.noise, self.names, self.robust = noise, list(calibration), robust
        self.times, self.poses = trajectory[:, 0], trajectory[:, 1:4].copy()
        self.poses[:, 2] = np.unwrap(self.poses[:, 2])
        self.start = self.poses[0].copy()
        self.errors = np.zeros((len(self.times), len(ERRORS)))
        self.calibration = {name: PRIORS[name][0] for name in PRIORS}
        self.scan = np.searchsorted(self.times, observations["t"] - 1e-6)
        self.ids, self.landmark = np.unique(observations["landmark"].astype(int),
                                            return_inverse=True)
        self.range, self.bearing = observations["range"], observations["bearing"]
        self.range_deviation = observations["range_deviation"]
        self.bearing_deviation = observations["bearing_deviation"]
        self._cut_motion(motion)
        self._place_landmarks()

    def _cut_motion(self, motion):
        """Pieces of constant input between scans: rows of scans, columns of pieces."""
        first = np.searchsorted(motion[:, 0], self.times[:-1], side="right") - 1
        last = np.searchsorted(motion[:, 0], self.times[1:], side="right") - 1
        index = first[:, None] + np.arange((last - first).max() + 1)[None]
        known = np.clip(index, 0, len(motion) - 1)
        begin = np.maximum(motion[known, 0], self.times[:-1, None])
        end = np.minimum(motion[np.clip(index + 1, 0, len(motion) - 1), 0], self.times[1:, None])
        end = np.where(index == last[:, None], self.times[1:, None], end)
        used = (index <= last[:, None]) & (index >= 0)
        self.piece_s = np.where(used, np.maximum(end - begin, 0.0), 0.0)
        self.speed, self.steering = motion[known, 1], motion[known, 2]
        self.duration = np.diff(self.times)

    def _place_landmarks(self):
        x, y, yaw = self.poses[self.scan].T
        a, b = CAR["laser"]
        seen = np.c_[x + a * np.cos(yaw) - b * np.sin(yaw) + self.range * np.cos(yaw + self.bearing),
                     y + a * np.sin(yaw) + b * np.cos(yaw) + self.range * np.sin(yaw + self.bearing)]
        count = np.bincount(self.landmark)
        self.landmarks = np.c_[np.bincount(self.landmark, seen[:, 0]) / count,
                               np.bincount(self.landmark, seen[:, 1]) / count]

    def _steps(self, calibration, errors):
        """Displacements between scans, in the frame of the first: rows of forward, left, turn."""
        n = self.noise
        relative_deviation = n["steering_deviation_relative"] * self.steering
        speed_deviation = np.hypot(n["speed_deviation_mps"],
                                   n["speed_deviation_relative"] * self.speed)
        t = np.tan(calibration["steering_scale"] * self.steering +
                   calibration["steering_offset_rad"] +
                   n["steering_deviation_rad"] * errors[:, 1:2] +
                   relative_deviation * errors[:, 2:])
        wheel = calibration["speed_scale"] * self.speed + speed_deviation * errors[:, :1]
        speed = wheel / (1.0 - t * CAR["encoder_left"] / CAR["wheelbase"])
        turns = speed * t / CAR["wheelbase"] * self.piece_s
        lengths = speed * self.piece_s * (1.0 - turns ** 2 / 24.0)
        middle = np.cumsum(turns, axis=1) - turns / 2.0
        return np.c_[(lengths * np.cos(middle)).sum(1), (lengths * np.sin(middle)).sum(1),
                     turns.sum(1)]

    def _linearize(self):
        rows, self.blocks = Rows(), {}
        self._width = STATES * len(self.times) + 2 * len(self.landmarks)
        velocity = self._add_motion(rows)
        self._add_errors(rows)
        self._add_observations(rows, velocity)
        for k, name in enumerate(self.names):
            nominal, deviation = PRIORS[name]
            rows.add(np.array([(self.calibration[name] - nominal) / deviation]),
                     [(np.array([self._width + k]), 1.0 / deviation)])
        return rows.matrix(self._width + len(self.names)), rows.residuals()

    def _add_motion(self, rows):
        middle = 0.5 * (self.errors[:-1] + self.errors[1:])
        steps = self._steps(self.calibration, middle)
        h = 1e-5
        by_calibration = {}
        for k, name in enumerate(self.names):
            moved = {**self.calibration, name: self.calibration[name] + h}
            by_calibration[k] = (self._steps(moved, middle) - steps) / h
        by_error = [(self._steps(self.calibration, middle + h * axis) - steps) / h
                    for axis in np.eye(len(ERRORS))]
        c, s = np.cos(self.poses[:-1, 2]), np.sin(self.poses[:-1, 2])
        d = np.diff(self.poses, axis=0)
        local = np.c_[c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], wrapped(d[:, 2])]
        speed = np.abs(steps[:, 0]) / self.duration
        slip = np.sqrt(2.0 * self.noise["correlation_time_s"] * self.duration) * \
            self.noise["lateral_deviation_relative"] * speed
        # Small floors keep the problem regular where the car stands.
        deviations = (np.full(len(d), 2e-4), np.hypot(slip, 2e-4), np.full(len(d), 2e-5))
        zero, one = np.zeros(len(d)), np.ones(len(d))
        gradients = ((-c, -s, local[:, 1], c, s, zero), (s, -c, -local[:, 0], -s, c, zero),
                     (zero, zero, -one, zero, zero, one))
        state = STATES * np.arange(len(d))
        for axis, (deviation, gradient) in enumerate(zip(deviations, gradients)):
            entries = [(state + k, gradient[k] / deviation) for k in range(3)]
            entries += [(state + STATES + k, gradient[3 + k] / deviation) for k in range(3)]
            for k in range(len(ERRORS)):
                half = -0.5 * by_error[k][:, axis] / deviation
                entries += [(state + 3 + k, half), (state + STATES + 3 + k, half)]
            entries += [(self._width + k, -J[:, axis] / deviation)
                        for k, J in by_calibration.items()]
            residual = local[:, axis] - steps[:, axis]
            self.blocks[("forward", "side_slip", "turn")[axis]] = rows.add(
                (wrapped(residual) if axis == 2 else residual) / deviation, entries)
        velocity = np.c_[steps[:, 0], steps[:, 2]] / self.duration[:, None]
        return np.vstack([velocity, velocity[-1:]])

    def _add_errors(self, rows):
        state = STATES * np.arange(len(self.duration))
        persistence = [self.noise.get(key) or self.noise["correlation_time_s"]
                       for key in ("speed_correlation_time_s", "correlation_time_s",
                                   "turn_relative_correlation_time_s")]
        for k, (name, persists_s) in enumerate(zip(ERRORS, persistence)):
            kept = np.exp(-self.duration / persists_s)
            renewed = np.sqrt(1.0 - kept ** 2)
            self.blocks[name] = rows.add(
                (self.errors[1:, k] - kept * self.errors[:-1, k]) / renewed,
                [(state + 3 + k, -kept / renewed), (state + STATES + 3 + k, 1.0 / renewed)])
            rows.add(self.errors[:1, k], [(np.array([3 + k]), 1.0)])
        for k in range(3):  # the map begins at the first pose
            rows.add(1e5 * (self.poses[:1, k] - self.start[k]), [(np.array([k]), 1e5)])

    def _add_observations(self, rows, velocity):
        n, cal = self.scan, self.calibration
        yaw = self.poses[n, 2]
        v = np.c_[velocity[n, 0] * np.cos(yaw), velocity[n, 0] * np.sin(yaw), velocity[n, 1]]
        pose = self.poses[n] + cal["time_offset_s"] * v
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        a, b = CAR["laser"]
        lever = np.c_[c * a - s * b, s * a + c * b]
        d = self.landmarks[self.landmark] - pose[:, :2] - lever
        distance = np.hypot(*d.T)
        e_range = self.range - distance * (1.0 + cal["range_scale"]) - cal["range_offset_m"]
        e_bearing = wrapped(self.bearing - np.arctan2(d[:, 1], d[:, 0]) + pose[:, 2] +
                            cal["laser_yaw_rad"])
        self.range_residual, self.bearing_residual = e_range, e_bearing
        cost = (e_range / self.range_deviation) ** 2 + (e_bearing / self.bearing_deviation) ** 2
        weight = 1.0 / np.sqrt(1.0 + cost / CAUCHY) if self.robust else np.ones(len(n))
        along, across = d / distance[:, None], np.c_[-d[:, 1], d[:, 0]] / distance[:, None] ** 2
        left = np.c_[-lever[:, 1], lever[:, 0]]
        nothing, one = np.zeros(len(n)), np.ones(len(n))
        for name, residual, deviation, u, turn, others in (
                ("range", e_range, self.range_deviation, along, 0.0,
                 {"range_offset_m": one, "range_scale": distance}),
                ("bearing", e_bearing, self.bearing_deviation, across, -1.0,
                 {"laser_yaw_rad": -one})):
            w = weight / deviation
            by_pose = np.c_[-u, turn - (u * left).sum(1)]
            others = {"time_offset_s": (by_pose * v).sum(1), **others}
            entries = [(STATES * n + k, -by_pose[:, k] * w) for k in range(3)]
            entries += [(STATES * len(self.times) + 2 * self.landmark + k, -u[:, k] * w)
                        for k in range(2)]
            entries += [(self._width + k, -others.get(known, nothing) * w)
                        for k, known in enumerate(self.names)]
            self.blocks[name] = rows.add(residual * w, entries)

    @staticmethod
    def _factor(normal):
        return splu(normal.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                    options={"SymmetricMode": True})

    def solve(self, iterations=15):
        """Gauss-Newton, until no pose moves by more than 0.1 mm."""
        for _ in range(iterations):
            J, residuals = self._linearize()
            step = self._factor(J.T @ J).solve(-(J.T @ residuals))
            scans = STATES * len(self.times)
            poses = step[:scans].reshape(-1, STATES)
            self.poses += poses[:, :3]
            self.errors += poses[:, 3:]
            self.landmarks += step[scans:self._width].reshape(-1, 2)
            for k, name in enumerate(self.names):
                self.calibration[name] += step[self._width + k]
            if np.abs(poses[:, :2]).max() < 1e-4:
                break
        return self

    def calibration_deviations(self):
        J, _ = self._linearize()
        factor = self._factor(J.T @ J)
        deviations = {}
        for k, name in enumerate(self.names):
            unit = np.zeros(J.shape[1])
            unit[self._width + k] = 1.0
            deviations[name] = float(np.sqrt(factor.solve(unit)[self._width + k]))
        return deviations

    def cost(self):
        """Sum of Cauchy losses of the observations and of all other squared residuals."""
        _, residuals = self._linearize()
        observed = np.concatenate([self.blocks["range"], self.blocks["bearing"]])
        others = np.ones(len(residuals), bool)
        others[observed] = False
        squared = (self.range_residual / self.range_deviation) ** 2 + \
            (self.bearing_residual / self.bearing_deviation) ** 2
        return float((residuals[others] ** 2).sum() + CAUCHY * np.log1p(squared / CAUCHY).sum())

    def gross_errors(self):
        """Which observations are off by more than four deviations."""
        return (np.abs(self.range_residual) > 4.0 * self.range_deviation) | \
            (np.abs(self.bearing_residual) > 4.0 * self.bearing_deviation)

    def variance_components(self, groups, probes=8):
        """Squared residuals over degrees of freedom, for groups of rows: 1 where the noise is what it
        claims to be. The degrees of freedom are estimated by random probes of the hat matrix."""
        J, residuals = self._linearize()
        factor = self._factor(J.T @ J)
        generator = np.random.default_rng(0)
        leverage = np.zeros(len(residuals))
        for _ in range(probes):
            probe = generator.choice([-1.0, 1.0], len(residuals))
            leverage += probe * (J @ factor.solve(J.T @ probe)) / probes
        return {name: float((residuals[rows] ** 2).sum() / (len(rows) - leverage[rows].sum()))
                for name, rows in groups(self).items()}
