"""RViz on a virtual screen of its own, for pictures of it and clicks into it."""
import os
import subprocess
import tempfile
import time

from PIL import ImageGrab


class RvizSession:
    def __init__(self, config, width=1280, height=800, environment=None):
        self._log = tempfile.TemporaryFile()
        read_end, write_end = os.pipe()
        self._screen = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{width}x{height}x24",
             "+extension", "GLX", "-nolisten", "tcp"],
            pass_fds=[write_end], stdout=self._log, stderr=self._log)
        os.close(write_end)
        with os.fdopen(read_end) as answer:
            self.display = ":" + answer.readline().strip()
        self._environment = {**os.environ, "DISPLAY": self.display, "LIBGL_ALWAYS_SOFTWARE": "1",
                             "QT_X11_NO_MITSHM": "1", **(environment or {})}
        # With it Debian's pluginlib would look nowhere else.
        self._environment.pop("AMENT_PREFIX_PATH", None)
        self.process = subprocess.Popen(
            ["rviz", "--splash-screen", "", "-d", str(config)],
            env=self._environment, stdout=self._log, stderr=subprocess.STDOUT)

    def is_running(self):
        return self.process.poll() is None

    def log(self):
        self._log.seek(0)
        return self._log.read().decode(errors="replace")

    def picture(self):
        return ImageGrab.grab(xdisplay=self.display).convert("RGB")

    def click(self, x, y):
        subprocess.run(["xdotool", "mousemove", str(round(x)), str(round(y)), "click", "1"],
                       env=self._environment, check=True)

    def cpu_s(self):
        """CPU time of RViz so far."""
        return sum(self.cpu_by_thread().values())

    def cpu_by_thread(self):
        """CPU time so far of threads of the same name; a name may stand for many."""
        used = {}
        for task in os.listdir(f"/proc/{self.process.pid}/task"):
            try:
                with open(f"/proc/{self.process.pid}/task/{task}/stat") as stat:
                    name, fields = stat.read().split("(", 1)[1].rsplit(")", 1)
            except OSError:  # it has ended meanwhile
                continue
            name, fields = name.rstrip("0123456789"), fields.split()
            used[name] = used.get(name, 0.0) + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        return used

    def close(self):
        for process in (self.process, self._screen):
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def wait_until(condition, timeout_s):
    """What the condition gives as soon as that is true; its last answer if it never is."""
    end = time.monotonic() + timeout_s
    while True:
        answer = condition()
        if answer or time.monotonic() > end:
            return answer
        time.sleep(0.2)
