"""Counts what scripts/test ran, names what failed or was skipped, and why.

Reads the JUnit files that ctest left in a folder and the lines `passed NAME`, `failed NAME` of
others.txt there. The last line printed is `N passed, N failed` with `, N skipped` if any were.
Exits with 1 if a test failed or none ran.
"""

import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree


def skip_reason(case):
    """The text that the test gave with GTEST_SKIP(), or an empty one."""
    match = re.search(r": Skipped\n(.*)", case.findtext("system-out") or "")
    return match.group(1).strip() if match else ""


def outcome_of(case):
    """'passed', 'failed' or 'skipped', and a sentence about it."""
    if case.get("status") == "run":
        return "passed", ""
    skipped = case.find("skipped")
    message = skipped.get("message", "") if skipped is not None else ""
    # A test whose program is missing was not run either, but nobody decided to skip it.
    if message.startswith("SKIP_") or case.get("status") == "disabled":
        return "skipped", skip_reason(case)
    failure = case.find("failure")
    return "failed", message or (failure.get("message", "") if failure is not None else "")


def read_outcomes(folder):
    for path in sorted(folder.glob("*.xml")):
        suffix = f" ({path.stem.replace('_', ' ')})" if path.stem.startswith("sanitizer_") else ""
        for case in ElementTree.parse(path).getroot().iter("testcase"):
            yield (case.get("name") + suffix, *outcome_of(case))
    others = folder / "others.txt"
    for line in others.read_text().splitlines() if others.exists() else []:
        outcome, name = line.split(" ", 1)
        yield name, outcome, ""


def main():
    outcomes = list(read_outcomes(pathlib.Path(sys.argv[1])))
    for wanted in ("skipped", "failed"):
        for name, outcome, reason in outcomes:
            if outcome == wanted:
                print(f"{wanted}: {name}" + (f": {reason}" if reason else ""))
    counts = {word: sum(o == word for _, o, _ in outcomes) for word in ("passed", "failed", "skipped")}
    if counts["passed"] + counts["failed"] == 0:
        print("No test ran.")
    line = f"{counts['passed']} passed, {counts['failed']} failed"
    print(line + (f", {counts['skipped']} skipped" if counts["skipped"] else ""))
    return 0 if counts["passed"] > 0 and counts["failed"] == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
