#!/usr/bin/python3
"""doc/topics_and_services.md has the topics and services that the code has; launch arguments, messages and services
are explained."""

import re
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "src"
PAGE = ROOT / "doc" / "topics_and_services.md"

ADVERTISED = re.compile(r'\b(?:advertise|serving)<([\w:]+)>\(\s*(?:\w+,\s*)?"([^"]+)"')
SERVICE = re.compile(r'\badvertiseService\(\s*"([^"]+)"')
SUBSCRIBED = re.compile(r'\b(?:subscribe(?:<([\w:]+)>)?|listen)\(\s*(?:\w+,\s*)?"([^"]+)"')
ACTION = re.compile(r'\bmake_unique<PlanServer>\(\s*\w+,\s*"([^"]+)"')
TF = {"/tf", "/tf_static"}
ACTION_SERVER = SOURCES / "ros" / "single_goal_server.h"  # its topics are those of every action


def own_services():
    return {file.stem for file in (ROOT / "srv").glob("*.srv")} | {"nav_msgs::GetMap"}


def executables():
    """The sources of each node, as src/nodes/CMakeLists.txt has them."""
    text = (SOURCES / "nodes" / "CMakeLists.txt").read_text()
    return {words[0]: [SOURCES / "nodes" / word for word in words[1:]]
            for words in (match.split() for match in re.findall(r"hymm_add_executable\(([^)]*)\)", text))}


def closure(sources):
    """These sources and all of ROS's side that they include, headers with their sources."""
    waiting, known = list(sources), set()
    while waiting:
        file = waiting.pop()
        if file in known or not file.exists():
            continue
        known.add(file)
        for folder, name in re.findall(r'#include "(ros|nodes)/([^"]+)"', file.read_text()):
            header = SOURCES / folder / name
            waiting.append(header)
            if folder == "ros":  # a node's own sources are those that CMake names
                waiting.append(header.with_suffix(".cpp"))
    return known


def type_name(cpp):
    return cpp.replace("::", "/")


def interface_of_code(sources):
    """Sets of (kind, name), and the types of some."""
    found, types = set(), {}
    services = own_services()
    for file in closure(sources) - {ACTION_SERVER}:
        text = file.read_text()
        for cpp, name in ADVERTISED.findall(text):
            kind = "service" if cpp in services else "out"
            found.add((kind, name))
            types[kind, name] = type_name(cpp)
        for cpp, name in SUBSCRIBED.findall(text):
            if name in TF:
                continue
            found.add(("in", name))
            if cpp:
                types["in", name] = type_name(cpp)
        found |= {("service", name) for name in SERVICE.findall(text)}
        found |= {("action", name) for name in ACTION.findall(text)}
    return found, types


def interface_of_page():
    """By node: (kind, name) and its type; private names without the node's."""
    nodes, node = {}, None
    for line in PAGE.read_text().splitlines():
        if line.startswith("## "):
            node = line[3:].strip()
        row = re.match(r"\| (in|out|service|action|calls) \| `([^`]+)` \| (\S+) \|", line)
        if row:
            kind, name, kind_of_message = row.groups()
            if kind in ("service", "out") and name.startswith(f"{node}/") and kind == "service":
                name = name[len(node) + 1:]
            nodes.setdefault(node, {})[kind, name] = kind_of_message
    return nodes


class InterfacePage(unittest.TestCase):
    def test_has_every_node(self):
        self.assertEqual(sorted(interface_of_page()), sorted(executables()))

    def test_has_the_topics_and_services_of_each_node(self):
        page = interface_of_page()
        for node, sources in executables().items():
            with self.subTest(node=node):
                found, _ = interface_of_code(sources)
                told = {item for item in page[node] if item[0] != "calls"}
                self.assertEqual(sorted(found - told), [], "missing in the page")
                self.assertEqual(sorted(told - found), [], "in the page, not in the code")

    def test_tells_the_types_that_the_code_names(self):
        page = interface_of_page()
        for node, sources in executables().items():
            for item, kind_of_message in interface_of_code(sources)[1].items():
                with self.subTest(node=node, item=item):
                    self.assertEqual(page[node].get(item), kind_of_message)

    def test_names_types_that_exist(self):
        own = {file.stem for folder in ("msg", "srv", "action") for file in (ROOT / folder).iterdir()}
        for node, items in interface_of_page().items():
            for item, kind_of_message in items.items():
                with self.subTest(node=node, item=item):
                    self.assertTrue("/" in kind_of_message or kind_of_message in own, kind_of_message)

    def test_finds_a_topic_that_is_not_told(self):
        found, _ = interface_of_code(executables()["supervisor"])
        self.assertIn(("out", "filter_status"), found)
        self.assertIn(("in", "relocaliser/health"), found, "of a class that the node uses")


class LaunchArguments(unittest.TestCase):
    def test_are_explained(self):
        files = sorted((ROOT / "launch").glob("*.launch"))
        self.assertGreater(len(files), 5)
        for file in files:
            for argument in ElementTree.parse(file).getroot().findall("arg"):
                with self.subTest(file=file.name, argument=argument.get("name")):
                    self.assertGreater(len(argument.get("doc", "")), 4)


class Messages(unittest.TestCase):
    def test_begin_with_what_they_are_for(self):
        files = [file for folder in ("msg", "srv", "action") for file in sorted((ROOT / folder).iterdir())]
        for file in files:
            with self.subTest(file=file.name):
                self.assertRegex(file.read_text(), r"\A# \w")

    def test_tell_the_unit_or_meaning_of_each_number(self):
        for folder in ("msg", "srv"):
            for file in sorted((ROOT / folder).glob(f"*.{folder}")):
                for line in file.read_text().splitlines():
                    if not re.match(r"(float32|float64)(\[\d*\])? \w+", line):
                        continue
                    with self.subTest(file=file.name, line=line):
                        self.assertIn("#", line)


if __name__ == "__main__":
    unittest.main()
