"""Checks the modules of src against the lists in their CMakeLists.txt:

    modules_rule.py ROOT

A file includes installed headers (HEADERS) and shared headers (SHARED) of the modules that its own
module names in DEPENDS, and no other header of another module. DEPENDS names no module in vain, and
makes no circle. The numbers of headers, programs and files in a folder stay below their limits.
"""

import pathlib
import re
import sys

MOST_INSTALLED_HEADERS = 61
MOST_SHARED_HEADERS = 46
MOST_FILES_IN_FOLDER = 30
MOST_PROGRAMS = 16

INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)


class Module:
    """A module: name, lists of files and dependencies, and the three sentences of its comment."""

    def __init__(self, name, text):
        self.name = name
        call = re.search(r"surfit_module\(([^)]*)\)", text).group(1).split()
        self.lists = {"DEPENDS": [], "HEADERS": [], "SHARED": [], "SOURCES": []}
        key = None
        for word in call[1:]:
            if word in self.lists:
                key = word
            else:
                self.lists[key].append(word)
        comment = re.match(r"(#[^\n]*\n)*", text).group(0)
        self.sentences = " ".join(comment.replace("#", " ").split())


def read_modules(root):
    modules = {}
    for path in sorted((root / "src").rglob("CMakeLists.txt")):
        text = path.read_text()
        if "\nsurfit_module(" in text:
            name = path.parent.relative_to(root / "src").as_posix()
            modules[name] = Module(name, text)
    return modules


def module_of(path, modules):
    """The module of a path below src, or None."""
    while path and path not in modules:
        path = path.rpartition("/")[0]
    return path or None


def files_of(root, module):
    folders = [root / "src" / module, root / "include/surfit" / module]
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix in (".h", ".cc"):
                yield path


def check_includes(root, modules):
    """Yields errors. Adds the modules that each module uses to `used`."""
    for name, module in modules.items():
        used = set()
        for path in files_of(root, name):
            for header in INCLUDE.findall(path.read_text()):
                where = f"{path.relative_to(root)} includes {header}"
                if header.startswith("surfit/"):
                    other = header.split("/")[1]
                    listed = header.split("/", 2)[2] in modules[other].lists["HEADERS"]
                elif header.startswith("cost_functions/"):
                    other, listed = "cost_functions", True
                else:
                    other = module_of(header, modules)
                    listed = other and header[len(other) + 1 :] in modules[other].lists["SHARED"]
                if other == name:
                    continue
                used.add(other)
                if not listed:
                    yield f"{where}, which {other} neither installs nor shares"
                if other not in module.lists["DEPENDS"]:
                    yield f"{where}, but {name} does not depend on {other}"
        for unused in sorted(set(module.lists["DEPENDS"]) - used):
            yield f"{name} depends on {unused}, but does not include it"


def check_sentences(modules):
    for name, module in modules.items():
        depends = ", ".join(module.lists["DEPENDS"]) or "nothing"
        if f"Depends on {depends}." not in module.sentences or " first" not in module.sentences:
            yield (
                f"src/{name}/CMakeLists.txt must begin with its content, 'Depends on {depends}.' "
                "and the file to read first"
            )


def check_circles(modules):
    left = {name: set(m.lists["DEPENDS"]) & set(modules) for name, m in modules.items()}
    while True:
        free = [name for name, depends in left.items() if not depends & set(left)]
        if not free:
            break
        for name in free:
            del left[name]
    if left:
        yield f"these modules depend on each other in a circle: {', '.join(sorted(left))}"


def check_limits(root, modules):
    def limit(count, most, what):
        if count > most:
            yield f"{count} {what}, at most {most} may be"

    installed = sum(len(m.lists["HEADERS"]) for m in modules.values())
    shared = sum(len(m.lists["SHARED"]) for m in modules.values())
    programs = len(list((root / "tools").glob("surfit_*.cc")))
    yield from limit(installed, MOST_INSTALLED_HEADERS, "installed headers")
    yield from limit(shared, MOST_SHARED_HEADERS, "shared headers")
    yield from limit(programs, MOST_PROGRAMS, "programs")
    for folder in sorted(path for path in (root / "src").rglob("*") if path.is_dir()):
        if "node_modules" not in folder.parts:
            files = sum(path.is_file() for path in folder.iterdir())
            yield from limit(files, MOST_FILES_IN_FOLDER, f"files in {folder.relative_to(root)}")


def main():
    root = pathlib.Path(sys.argv[1])
    modules = read_modules(root)
    if not modules:
        sys.exit(f"error: no module under {root}/src")
    errors = [
        *check_includes(root, modules),
        *check_sentences(modules),
        *check_circles(modules),
        *check_limits(root, modules),
    ]
    for error in errors:
        print(f"error: {error}")
    sys.exit(bool(errors))


if __name__ == "__main__":
    main()
