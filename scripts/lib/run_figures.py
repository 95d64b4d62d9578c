"""Pictures of a run's results."""

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import EllipseCollection, PatchCollection, PolyCollection
from matplotlib.patches import Patch, Rectangle
from run_results import Lacks

TRAJECTORY = "#1f5fa8"
GPS = "#d1495b"
LANDMARK = "#2e7d4f"
LTR = "#8a5fb0"
MODES = {"CEKF": "#2e7d4f", "RELOCALISING": "#e0a030", "LOST": "#c0392b"}
OTHER_MODE = "0.5"
UNKNOWN = 205  # in map.pgm
FINEST_PICTURE = 1500  # pixels along a side: of finer maps a block is as dark as its darkest cell


def map_figure(results, size=(10, 10)):
    """Trajectory, landmarks with 2 sigma ellipses, and GPS where there is some."""
    poses = results.poses
    figure, axes = plt.subplots(figsize=size)
    try:
        fixes = results.fixes_in_map()
        axes.plot(fixes[:, 0], fixes[:, 1], "x", color=GPS, markersize=4, markeredgewidth=1.0,
                  label="GPS, aligned", zorder=4)
    except Lacks:
        pass
    _draw_trajectory(axes, poses)
    landmarks = results.landmarks
    _draw_landmarks(axes, landmarks)
    axes.set_title(f"{len(landmarks)} landmarks, {len(poses)} scans", fontsize=11)
    return _finished_map(figure, axes)


def dense_figure(results, size=(10, 10)):
    """Occupancy under the triangles (LTRs) that carry it."""
    ltrs, places = results.ltrs, results.places()
    figure, axes = plt.subplots(figsize=size)
    try:
        draw_occupancy(axes, results)
        title = "occupied black, free white, unknown grey"
    except Lacks as lacks:
        title = str(lacks)
    corners = [[places[i] for i in ltr] for ltr in ltrs if all(i in places for i in ltr)]
    axes.add_collection(PolyCollection(corners, facecolors="none", edgecolors=LTR, linewidths=0.5,
                                       zorder=2))
    axes.plot(*np.array(list(places.values())).T, ".", color=LANDMARK, markersize=3, label="landmarks")
    axes.plot([], [], "-", color=LTR, label="LTRs")
    axes.set_title(f"{len(corners)} LTRs; {title}", fontsize=11)
    return _finished_map(figure, axes)


def draw_occupancy(axes, results):
    """The cells that are known, and nothing beyond them."""
    pixels, extent = results.occupancy
    axes.imshow(_coarser(pixels), extent=extent, cmap="gray", vmin=0, vmax=255, zorder=0)
    _show_what_is_known(axes, pixels, extent)


def level_set_figure(results, size=(10, 10)):
    """Nested level sets, darker for more information, and where exploring was suggested."""
    leaves = results.level_sets
    figure, axes = plt.subplots(figsize=size)
    values = np.unique(leaves[:, 0])
    shades = plt.get_cmap("Blues")(np.linspace(0.25, 0.65, len(values)))
    handles = []
    for value, shade in zip(values, shades):
        of_value = leaves[leaves[:, 0] == value]
        squares = [Rectangle((x - edge / 2, y - edge / 2), edge, edge)
                   for _, x, y, edge, _ in of_value]
        axes.add_collection(PatchCollection(squares, facecolor=shade, edgecolor=shade, linewidth=0.2,
                                            zorder=1))
        area, islands = (of_value[:, 3] ** 2).sum(), len(np.unique(of_value[:, 4]))
        handles.append(Patch(color=shade, label=f"{value:g} per m² (deviation {value ** -0.5:.2g} m): "
                                                f"{area:.0f} m², {_count(islands, 'island')}"))
    places = np.array(list(results.places().values())).reshape(-1, 2)
    handles += axes.plot(places[:, 0], places[:, 1], ".", color=LANDMARK, markersize=4,
                         label="landmarks", zorder=3)
    try:
        goals = results.exploration
        handles += axes.plot(goals[:, 0], goals[:, 1], "^", color=GPS, markersize=6,
                             label="suggested to explore from the last pose", zorder=4)
    except Lacks:
        pass
    axes.autoscale_view()
    return _finished_map(figure, axes, handles=handles)


def plan_figure(results, size=(10, 10)):
    """The path over LTRs and doors."""
    path = results.plan  # first of all: where there is none, nothing else is missed
    figure, axes = plt.subplots(figsize=size)
    draw_plan(axes, results, results.places())
    axes.set_title(f"{len(path)} points", fontsize=11)
    return _finished_map(figure, axes)


def draw_plan(axes, results, places):
    """The path, LTRs and portals where landmarks are at `places`."""
    path = results.path_among(places)
    corners = [[places[i] for i in ltr] for ltr in results.ltrs if all(i in places for i in ltr)]
    axes.add_collection(PolyCollection(corners, facecolors=LTR, alpha=0.08, edgecolors="none", zorder=1))
    axes.add_collection(PolyCollection(corners, facecolors="none", edgecolors=LTR, linewidths=0.4,
                                       zorder=1))
    axes.plot(*results.portals_among(places).T, ".", color="#e0a030", markersize=3,
              label="portals of doors", zorder=2)
    axes.plot(*np.array(list(places.values())).T, ".", color=LANDMARK, markersize=4, label="landmarks",
              zorder=2)
    axes.plot(*path.T, "-", color=GPS, linewidth=2.0, label="plan", zorder=3)
    axes.plot(*path[0], "o", color=GPS, markersize=7, label="its start", zorder=4)


def _draw_trajectory(axes, poses):
    axes.plot(poses[:, 1], poses[:, 2], color=TRAJECTORY, linewidth=1.0, label="trajectory", zorder=3)
    axes.plot(*poses[0, 1:3], "o", color=TRAJECTORY, markersize=7, label="start", zorder=5)


def _finished_map(figure, axes, handles=None):
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(True, color="0.9")
    axes.set_axisbelow(True)
    # Below the map, which may fill its frame.
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncol=4 if handles is None else 2,
                fontsize=9, handles=handles)
    figure.tight_layout()
    return figure


def _show_what_is_known(axes, pixels, extent, margin_m=5.0):
    rows, columns = (np.flatnonzero((pixels != UNKNOWN).any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return
    resolution = (extent[1] - extent[0]) / pixels.shape[1]
    axes.set_xlim(extent[0] + columns[0] * resolution - margin_m,
                  extent[0] + (columns[-1] + 1) * resolution + margin_m)
    axes.set_ylim(extent[3] - (rows[-1] + 1) * resolution - margin_m,
                  extent[3] - rows[0] * resolution + margin_m)
    axes.set_facecolor(str(UNKNOWN / 255))


def _coarser(pixels):
    step = max(1, int(np.ceil(max(pixels.shape) / FINEST_PICTURE)))
    height, width = (-(-side // step) * step for side in pixels.shape)
    padded = np.full((height, width), UNKNOWN, dtype=pixels.dtype)
    padded[:pixels.shape[0], :pixels.shape[1]] = pixels
    return padded.reshape(height // step, step, width // step, step).min(axis=(1, 3))


def _count(number, noun):
    return f"{number} {noun}" + ("" if number == 1 else "s")


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
    time = results.health_column("t")
    time = time - time[0]
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
    modes = [row.get("mode") or "?" for row in results.health]
    begin = 0
    for end in range(1, len(modes) + 1):
        if end == len(modes) or modes[end] != modes[begin]:
            axes.axvspan(time[begin], time[end - 1], ymax=0.03,
                         color=MODES.get(modes[begin], OTHER_MODE))
            begin = end
    axes.legend(handles=[Patch(color=MODES.get(mode, OTHER_MODE), label=mode)
                         for mode in dict.fromkeys(modes)],
                loc="upper right", ncol=4, fontsize=9, title="in charge", title_fontsize=9)
