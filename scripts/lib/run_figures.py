"""Pictures of a run's results."""

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import EllipseCollection

TRAJECTORY = "#1f5fa8"
GPS = "#d1495b"
LANDMARK = "#2e7d4f"
MODES = {"CEKF": "#2e7d4f", "RELOCALISING": "#e0a030", "LOST": "#c0392b"}


def map_figure(results, size=(10, 10)):
    """Trajectory, landmarks with 2 sigma ellipses, and GPS where there is some."""
    figure, axes = plt.subplots(figsize=size)
    fixes = results.fixes_in_map()
    if len(fixes):
        axes.plot(fixes[:, 0], fixes[:, 1], "x", color=GPS, markersize=4, markeredgewidth=1.0,
                  label="GPS, aligned", zorder=4)
    axes.plot(results.positions[:, 0], results.positions[:, 1], color=TRAJECTORY, linewidth=1.0,
              label="trajectory", zorder=3)
    if len(results.positions):
        axes.plot(*results.positions[0], "o", color=TRAJECTORY, markersize=7, label="start", zorder=5)
    _draw_landmarks(axes, results.landmarks)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(True, color="0.9")
    axes.set_axisbelow(True)
    axes.legend(loc="best", framealpha=0.9)
    axes.set_title(f"{len(results.landmarks)} landmarks, {len(results.times)} scans", fontsize=11)
    figure.tight_layout()
    return figure


def _draw_landmarks(axes, landmarks):
    if not landmarks:
        return
    centres = np.array([[float(m["x"]), float(m["y"])] for m in landmarks])
    covariances = np.array([[[float(m["cxx"]), float(m["cxy"])],
                             [float(m["cxy"]), float(m["cyy"])]] for m in landmarks])
    values, vectors = np.linalg.eigh(covariances)
    diameters = 4.0 * np.sqrt(np.maximum(values, 0.0))  # 2 sigma to either side
    angles = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))
    axes.add_collection(EllipseCollection(
        diameters[:, 1], diameters[:, 0], angles, units="xy", offsets=centres,
        offset_transform=axes.transData, facecolors="none", edgecolors=LANDMARK, linewidths=0.7,
        zorder=2))
    axes.plot(centres[:, 0], centres[:, 1], ".", color=LANDMARK, markersize=4,
              label="landmarks, 2σ", zorder=2)


def health_figure(results):
    """What the filter says about itself, over time."""
    time = results.times - (results.times[0] if len(results.times) else 0.0)
    figure, axes = plt.subplots(3, 1, figsize=(10, 7), sharex=True)
    dof = results.health_column("dof")
    has_update = dof > 0
    axes[0].plot(time[has_update], results.health_column("nis")[has_update] / dof[has_update], ".",
                 color=TRAJECTORY, markersize=1.5)
    axes[0].axhline(1.0, color="0.4", linewidth=0.8)
    axes[0].set_ylabel("NIS per degree\nof freedom")
    axes[0].set_ylim(0.0, 5.0)
    for name, color in (("unexplained", GPS), ("missed", "#e0a030"), ("ambiguity", LANDMARK)):
        axes[1].plot(time, _smooth(results.health_column(name)), color=color, linewidth=1.0,
                     label=name)
    axes[1].set_ylabel("share, mean of\n25 scans")
    axes[1].set_ylim(0.0, 1.0)
    axes[1].legend(loc="upper right", ncol=3, fontsize=9)
    axes[2].plot(time, results.health_column("latency_ms"), ".", color=TRAJECTORY, markersize=1.5)
    axes[2].set_yscale("log")
    axes[2].set_ylabel("latency [ms]")
    axes[2].set_xlabel("time since the first scan [s]")
    for axis in axes:
        axis.grid(True, color="0.9")
        axis.set_axisbelow(True)
    _draw_modes(axes[2], results, time)
    figure.align_ylabels(axes)
    figure.tight_layout()
    return figure


def latency_figure(results):
    """How the times of single scans are distributed."""
    figure, axes = plt.subplots(figsize=(10, 3.5))
    latency = results.health_column("latency_ms")
    latency = latency[latency > 0.0]
    if len(latency):
        bins = np.geomspace(latency.min(), latency.max() * 1.001, 80)
        axes.hist(latency, bins=bins, color=TRAJECTORY)
        axes.set_xscale("log")
        for share, text in ((50, "median"), (95, "95 %"), (99, "99 %")):
            value = np.percentile(latency, share)
            axes.axvline(value, color="0.3", linewidth=0.8)
            axes.text(value, 0.97, f" {text}", transform=axes.get_xaxis_transform(), fontsize=9,
                      va="top")
    axes.set_xlabel("latency of a scan [ms]")
    axes.set_ylabel("scans")
    figure.tight_layout()
    return figure


def _smooth(values, width=25):
    if len(values) < width:
        return values
    return np.convolve(np.pad(values, width // 2, mode="edge"), np.ones(width) / width, "valid")


def _draw_modes(axes, results, time):
    """The filter in charge, as a strip along the bottom."""
    modes = [row["mode"] for row in results.health]
    begin = 0
    for end in range(1, len(modes) + 1):
        if end == len(modes) or modes[end] != modes[begin]:
            axes.axvspan(time[begin], time[end - 1], ymax=0.03,
                         color=MODES.get(modes[begin], "0.5"))
            begin = end
