#!/usr/bin/python3
"""Each type at namespace scope has one definition: two of one name in hymm::core, in sources that never meet in one
translation unit, would compile, and then share the member functions of their containers."""
import collections
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{")
DEFINITION = re.compile(r"^(?:struct|class|enum class) (\w+)(?: final)?(?: :[^:].*)? \{")


def named_types(path):
    """Types that a source defines, with their namespace; what is in an unnamed one is the file's own."""
    namespace, is_unnamed = "", False
    for line in path.read_text(encoding="utf-8").splitlines():
        if line == "namespace {":
            is_unnamed = True
        elif line == "}  // namespace":
            is_unnamed = False
        elif NAMESPACE.match(line):
            namespace = NAMESPACE.match(line).group(1)
        match = DEFINITION.match(line)
        if match and not is_unnamed:
            yield f"{namespace}::{match.group(1)}"


class OneDefinition(unittest.TestCase):
    def test_no_type_is_defined_twice(self):
        places = collections.defaultdict(list)
        for folder in [*(ROOT / "src").iterdir(), ROOT / "test" / "support"]:
            for path in sorted([*folder.glob("*.h"), *folder.glob("*.cpp")]):
                for name in named_types(path):
                    places[name].append(str(path.relative_to(ROOT)))
        self.assertIn("hymm::core::Barrier", places)
        self.assertEqual({name: found for name, found in places.items() if len(found) > 1}, {})


if __name__ == "__main__":
    unittest.main()
