"""What the experiments share: where the tools are, how they run, how the outcome is written."""

import argparse
import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Experiment:
    """Command line, tools and outcome of one experiment."""

    def __init__(self, name, description, seeds):
        parser = argparse.ArgumentParser(description=description)
        parser.add_argument("--seeds", type=int, default=seeds, help="number of seeds")
        parser.add_argument("--output", type=Path, default=ROOT / "out/experiments")
        parser.add_argument("--build", type=Path, default=ROOT / "build_release",
                            help="folder that the tools were built in")
        arguments = parser.parse_args()
        self.name = name
        self.seeds = arguments.seeds
        self.output = arguments.output.resolve()
        self.output.mkdir(parents=True, exist_ok=True)
        self.work = self.output / name
        self.work.mkdir(exist_ok=True)
        self._tools = arguments.build / "devel/lib/hymm"

    def run(self, tool, *arguments):
        """Runs a tool of the package; returns what it printed on standard output."""
        command = [str(self._tools / tool), *map(str, arguments)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"{shlex.join(command)} failed:\n{done.stderr}")
        return done.stdout

    def evaluate(self, *arguments):
        return json.loads(self.run("hymm_evaluate", *arguments))

    def finish(self, figures, goals, **details):
        """Writes NAME.json and prints its figures."""
        commit = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"],
                                stdout=subprocess.PIPE, text=True).stdout.strip()
        outcome = {
            **figures,
            "goals": goals,
            **details,
            "command": f"scripts/experiments/{self.name} --seeds {self.seeds}",
            "commit": commit,
            "cores": os.cpu_count(),
        }
        (self.output / f"{self.name}.json").write_text(json.dumps(outcome, indent=2) + "\n")
        for key, value in figures.items():
            goal = f"   (goal {goals[key]})" if key in goals else ""
            print(f"{key}: {value:.6g}{goal}")
