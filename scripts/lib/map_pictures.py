"""Draws maps that were exported as pgm and yaml."""

import json

import numpy as np
from scipy.ndimage import minimum_filter
from scipy.spatial import cKDTree

OCCUPIED, UNKNOWN = 0, 205  # pixels


def read_pgm(path):
    """Pixels with the first row at the bottom, and the extent in metres for imshow."""
    data = path.with_suffix(".pgm").read_bytes()
    magic, size, depth, pixels = data.split(b"\n", 3)
    width, height = map(int, size.split())
    image = np.frombuffer(pixels, np.uint8).reshape(height, width)[::-1]
    yaml = dict(line.split(": ", 1) for line in path.with_suffix(".yaml").read_text().splitlines())
    x, y, _ = json.loads(yaml["origin"])
    step = float(yaml["resolution"])
    return image, (x, x + step * width, y, y + step * height)


def known_window(path):
    """The box around all that is known: (x0, x1, y0, y1)."""
    image, extent = read_pgm(path)
    rows, columns = np.nonzero(image != UNKNOWN)
    step = (extent[1] - extent[0]) / image.shape[1]
    return (extent[0] + step * columns.min(), extent[0] + step * columns.max(),
            extent[2] + step * rows.min(), extent[2] + step * rows.max())


def moved_window(before, after, reach_m):
    """The window, `reach_m` to each side, in which most obstacles of one map have none near in another."""
    def obstacles(path):
        image, extent = read_pgm(path)
        rows, columns = np.nonzero(image == OCCUPIED)
        step = (extent[1] - extent[0]) / image.shape[1]
        return np.column_stack((extent[0] + step * columns, extent[2] + step * rows))

    was, now = obstacles(before), obstacles(after)
    moved = was[cKDTree(now).query(was)[0] > 1.0]
    near = cKDTree(moved).query_ball_point(moved, reach_m, p=np.inf, return_length=True)
    x, y = moved[np.argmax(near)] if len(moved) else was.mean(axis=0)
    return x - reach_m, x + reach_m, y - reach_m, y + reach_m


def show_map(axis, path, window, title, thicken=2):
    """`thicken`: cells by which what is occupied is widened, so that none of it falls between the
    pixels of a picture that has fewer than the map has cells."""
    image, extent = read_pgm(path)
    image = minimum_filter(image, thicken) if thicken > 1 else image
    axis.imshow(image, origin="lower", extent=extent, cmap="gray", vmin=0, vmax=255,
                interpolation="nearest")
    axis.set(xlim=window[:2], ylim=window[2:], title=title)
    axis.set_aspect("equal")
