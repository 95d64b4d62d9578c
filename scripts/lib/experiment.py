"""What the experiments share: where the tools are, how they run, how the outcome is written."""

import argparse
import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

from commit import commit

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
        self._build = arguments.build
        self.commit = commit()

    def run(self, tool, *arguments):
        """Runs a tool of the package; returns what it printed on standard output."""
        return self._call(self.tool(tool), *arguments)

    def run_test_program(self, program, *arguments):
        """The same with a program that was built with the tests."""
        return self._call(self.test_program(program), *arguments)

    def test_program(self, name):
        """Where a program that was built with the tests is."""
        return self._build / "tests" / name

    def tool(self, name):
        """Where a tool of the package is."""
        return self._build / "devel/lib/hymm" / name

    @staticmethod
    def _call(program, *arguments):
        command = [str(program), *map(str, arguments)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"{shlex.join(command)} failed:\n{done.stderr}")
        return done.stdout

    def evaluate(self, *arguments):
        return json.loads(self.run("hymm_evaluate", *arguments))

    def finish(self, figures, goals, **details):
        """Writes NAME.json and prints its figures."""
        outcome = {
            **figures,
            "goals": goals,
            **details,
            "command": f"scripts/experiments/{self.name} --seeds {self.seeds}",
            "commit": self.commit,
            "cores": os.cpu_count(),
        }
        (self.output / f"{self.name}.json").write_text(json.dumps(outcome, indent=2) + "\n")
        for key, value in figures.items():
            goal = f"   (goal {goals[key]})" if key in goals else ""
            print(f"{key}: {value:.6g}{goal}")
