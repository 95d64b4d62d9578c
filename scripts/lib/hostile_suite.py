"""A master of its own with the suite's nodes, each to be started, stopped and watched by itself."""

import ctypes
import os
import random
import signal
import socket
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NODES = ["cekf_slam", "hymm_grid", "information_map", "door_planner", "relocaliser", "supervisor",
         "dead_reckoning", "recorder"]
ENDED_AT_ONCE_S = 60.0  # far more than any node may take


def ends_with_us(with_signal):
    """For Popen: what we started ends when this process does, however that comes about."""
    return lambda: ctypes.CDLL("libc.so.6").prctl(1, with_signal)  # PR_SET_PDEATHSIG


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def quiet(*command):
    return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode


def wait_for(condition, seconds):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


class Suite:
    """The nodes run as ordinary processes, so that their exit codes and memory are seen."""

    def __init__(self, build, folder, with_master=True):
        self.tools = build / "devel/lib/hymm"
        self.folder = folder
        self.running, self.crashes, self.players = {}, [], []
        self.port, self.master = free_port(), None
        os.environ.update(ROS_MASTER_URI=f"http://localhost:{self.port}", ROS_HOSTNAME="localhost",
                          ROS_HOME=str(folder / "ros_home"))
        os.environ["ROS_PACKAGE_PATH"] = f"{ROOT}:{os.environ.get('ROS_PACKAGE_PATH', '')}"
        if with_master:
            self.start_master()

    def start_master(self):
        self.master = self.begin(["roscore", "-p", str(self.port)], signal.SIGINT)
        if not wait_for(lambda: quiet("rosparam", "list") == 0, 60.0):
            raise RuntimeError("roscore does not answer.")

    @staticmethod
    def begin(command, death=signal.SIGKILL, log=subprocess.DEVNULL):
        # roslaunch would keep what it says to itself until it has 8 kB, where that goes to a file.
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        return subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=log,
                                stderr=log, env=environment, preexec_fn=ends_with_us(death))

    def configure(self, *overlays, **parameters):
        """Parameters as the launch files set them; `cekf_slam__gps__enabled` is cekf_slam/gps/enabled."""
        for name in NODES:
            file = ROOT / f"config/{name}.yaml"
            if file.exists():
                quiet("rosparam", "load", str(file))
        for overlay in overlays:
            quiet("rosparam", "load", str(overlay))
        for name, value in parameters.items():
            quiet("rosparam", "set", name.replace("__", "/"), str(value))

    def start(self, *names):
        for name in names or NODES:
            with open(self.folder / f"{name}.log", "a") as log:
                self.running[name] = self.begin([self.tools / name, f"__name:={name}"], log=log)

    def note_crashes(self):
        """Nodes that ended without being told to, with whatever exit code, are crashes."""
        for name, process in list(self.running.items()):
            if process.poll() is not None:
                self.crashes.append(f"{name} ended by itself, with {process.returncode}")
                del self.running[name]
        return self.crashes

    def kill(self, name):
        self.note_crashes()
        process = self.running.pop(name, None)
        if process:
            process.kill()
            process.wait()

    def interrupt(self, *names):
        """Seconds that nodes take to end after Ctrl-C; what does not end is killed, a crash."""
        self.note_crashes()
        ending = {name: self.running.pop(name) for name in names if name in self.running}
        begin, took_s = time.monotonic(), 0.0
        for process in ending.values():
            process.send_signal(signal.SIGINT)
        for name, process in ending.items():
            try:
                process.wait(ENDED_AT_ONCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                self.crashes.append(f"{name} did not end after SIGINT")
            else:
                if process.returncode != 0:
                    self.crashes.append(f"{name} ended with {process.returncode} after SIGINT")
            took_s = time.monotonic() - begin
        return took_s

    def rss_mb(self):
        sizes = {}
        for name, process in self.running.items():
            try:
                pages = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1])
                sizes[name] = pages * os.sysconf("SC_PAGE_SIZE") / 1e6
            except (OSError, IndexError):
                pass
        return sizes

    def play(self, bag, *arguments):
        """Without the bag's own odometry: that is the node dead_reckoning's affair."""
        player = self.begin(["rosbag", "play", "--quiet", "--clock", *arguments, bag,
                             "odom:=recorded/odom", "/tf:=recorded/tf"], signal.SIGINT)
        self.players.append(player)
        return player

    @staticmethod
    def stop(process):
        process.send_signal(signal.SIGINT)
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def end(self):
        for player in self.players:
            self.stop(player)
        for name in list(self.running):
            self.interrupt(name)
        self.stop_master()

    def stop_master(self):
        if self.master:
            self.stop(self.master)
        self.master = None


def cut_bags(bag, folder, count, seed):
    """Copies of a bag, cut off at random bytes."""
    content = Path(bag).read_bytes()
    draw = random.Random(seed)
    for number in range(count):
        path = folder / f"cut_{number}.bag"
        path.write_bytes(content[:draw.randrange(len(content))])
        yield path
        path.unlink()
