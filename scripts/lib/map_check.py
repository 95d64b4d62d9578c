"""Whether a folder holds a map that is whole, whatever happened while it was saved."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OVERLAY = ROOT / "config/datasets/car_park.yaml"


class MapCheck:
    def __init__(self, tools, work):
        """`work` is a folder for what it needs."""
        self.tools, self.work, self.bag = tools, work, work / "check.bag"
        subprocess.run([str(tools / "simulate_world"), "--world", "car_park", "--duration", "2", "--output",
                        str(self.bag)], check=True, stdout=subprocess.DEVNULL)

    def problem_of(self, folder):
        """What hymm_offline says of the map; nothing if it is whole."""
        done = subprocess.run(
            [str(self.tools / "hymm_offline"), "--bag", str(self.bag), "--load", str(folder),
             "--localise-only", "--config", str(OVERLAY), "--only", "cekf_slam,hymm_grid", "--output",
             str(self.work / "checked")], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        return "" if done.returncode == 0 else f"exit code {done.returncode}, {done.stderr[-300:]}"
