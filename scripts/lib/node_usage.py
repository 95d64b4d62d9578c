"""CPU and memory of the nodes that a roslaunch starts, read from /proc while they live."""

import os
import threading
from pathlib import Path

PERIOD_S = 0.25
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def _stat(process):
    """(parent, CPU seconds) of a process; its name may hold spaces and brackets."""
    fields = (process / "stat").read_text().rpartition(")")[2].split()
    return int(fields[1]), (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def _peak_mb(process):
    for line in (process / "status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024 / 1e6
    return 0.0


def _node_name(process):
    for word in (process / "cmdline").read_bytes().split(b"\0"):
        if word.startswith(b"__name:="):
            return word[len(b"__name:="):].decode()
    return None


def _processes():
    """(id, folder, parent, CPU seconds) of all that can be read."""
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            found.append((int(folder.name), folder, *_stat(folder)))
        except OSError:  # it has ended meanwhile
            continue
    return found


def _descendants(root, processes):
    family, grown = {root}, True
    while grown:
        children = {pid for pid, _, parent, _ in processes if parent in family} - family
        family |= children
        grown = bool(children)
    return family


class NodeUsage:
    """Watches the descendants of a process until it ends: `with NodeUsage(pid) as usage: …`."""

    def __init__(self, root):
        self._root = root
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._cpu_s, self._peak_mb = {}, {}

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join()

    def _watch(self):
        while not self._ended.wait(PERIOD_S):
            self._read()

    def _read(self):
        processes = _processes()
        family = _descendants(self._root, processes)
        for pid, folder, _, cpu_s in processes:
            if pid not in family:
                continue
            try:
                node, peak_mb = _node_name(folder), _peak_mb(folder)
            except OSError:
                continue
            if node:
                self._cpu_s[node] = max(cpu_s, self._cpu_s.get(node, 0.0))
                self._peak_mb[node] = max(peak_mb, self._peak_mb.get(node, 0.0))

    def figures(self):
        """`cpu_s_NODE` up to a moment before its end, `peak_rss_mb_NODE` (MB are 10^6 bytes)."""
        figures = {}
        for node in sorted(self._cpu_s):
            figures[f"cpu_s_{node}"] = round(self._cpu_s[node], 2)
            figures[f"peak_rss_mb_{node}"] = round(self._peak_mb[node], 1)
        return figures
