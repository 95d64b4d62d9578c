"""Tells in ten lines what the demo did and how to go on. Arguments: the demo's folder, its bag."""

import json
import os
import pathlib
import subprocess
import sys


def position_rmse_m(folder, bag):
    """Of the live trajectory against the simulator's truth in the bag."""
    command = ["rosrun", "hymm", "hymm_evaluate", "--results", folder, "--bag", bag]
    result = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(result.stdout)["trajectory"]["rmse_m"]


def main():
    folder, bag = pathlib.Path(sys.argv[1]), sys.argv[2]
    summary = json.loads((folder / "summary.json").read_text())
    latency = summary["scan_latency_ms"]
    shown = os.path.relpath(folder)
    print(f"""
A car drove {summary['duration_s']:.0f} s through a simulated car park; hymm followed it live.
  {summary['scans']} scans ({summary['dropped_scans']} dropped), \
{latency['p50']:.1f} ms each, {latency['p99']:.1f} ms for the slowest in a hundred
  {summary['landmarks']} landmarks mapped; the car was located to \
{position_rmse_m(str(folder), bag):.2f} m (RMS, against the simulator's truth)
  {shown}/map.png the map, {shown}/rviz.png what RViz showed,
  {shown}/report.html everything on one page, {shown}/summary.json the figures
A recording of your own (scan, and dead_reckoning or odom; bags/README.md tells how to convert):
  source build_release/devel/setup.bash
  roslaunch hymm playback.launch bag:=/path/to/your.bag config:=/path/to/your_robot.yaml rviz:=true
  rosrun hymm hymm_offline --bag your.bag --config your_robot.yaml --output out/yours   # faster""")


if __name__ == "__main__":
    main()
