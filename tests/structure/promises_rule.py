#!/usr/bin/env python3
"""Checks that each test in docs/promises.md exists: promises_rule.py ROOT

Names are in code quotes: googletest patterns (Suite.Name, with *), tests of CMake (live.viewers), and
paths of test files. Other quoted words are file names of Surfit, which have an extension of FILES.
"""
import fnmatch
import pathlib
import re
import sys

FILES = {"txt", "csv", "json", "yaml", "db", "oni", "klg"}
GTEST = re.compile(r"^(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)
CTEST = re.compile(r"add_test\(NAME ([\w.]+)")
QUOTED = re.compile(r"`([^`\s]+)`")
NAME = re.compile(r"^(?:\w+/)?([\w*]+\.[\w*]+)$")


def tests_of(root):
    """Names of all tests, without prefixes of parameterised suites."""
    names = set()
    for path in (root / "tests").rglob("*.cc"):
        names |= {"%s.%s" % match for match in GTEST.findall(path.read_text())}
    for path in (root / "tests").rglob("CMakeLists.txt"):
        names |= set(CTEST.findall(path.read_text()))
    for path in (root / "tests/live").glob("test_*.py"):
        names.add("live." + path.stem[len("test_"):])
    return names


def missing(text, names, root):
    """Quoted names that match no test and no file."""
    found = []
    count = 0
    for quoted in QUOTED.findall(text):
        if quoted.startswith("tests/"):
            count += 1
            if not (root / quoted).is_file():
                found.append(quoted)
            continue
        match = NAME.match(quoted)
        if not match or quoted.rsplit(".", 1)[1] in FILES:
            continue
        count += 1
        if not fnmatch.filter(names, match.group(1)):
            found.append(quoted)
    return found, count


def main():
    root = pathlib.Path(sys.argv[1])
    names = tests_of(root)
    found, count = missing((root / "docs/promises.md").read_text(), names, root)
    for name in found:
        print("docs/promises.md names the test %s, which does not exist" % name)
    wrong, _ = missing("`No.SuchTest` `Slam.No*` `tests/none.sh`", names, root)
    if len(wrong) != 3 or count < 100:
        print("the check is broken: it found %d names in docs/promises.md, and accepts false names" % count)
        return 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
