#!/usr/bin/env python3
"""Counts how many deliberate faults the tests find.

    mutate.py [--list] [--only=NAME|MODULE] [--build-folder=build/mutate] [--jobs=N]

mutations.txt lists the faults. The script copies the source tree to the build folder and puts all faults into one
build. The environment variable SURFIT_MUTATION selects a fault by its number; 0 or no value selects none.

Each fault runs the tests of its module without slow tests, then with slow tests, then all other tests of test.sh. The
first failure ends the run of a fault. The same tests must pass without a fault.

The build folder keeps the results in results.json. A fault with a result is skipped unless --only names the fault or
its module. Remove results.json to begin anew.
"""
import argparse
import configparser
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Test programs of each module, as a regular expression.
MODULES = {
    "tracking": "slam|frame",
    "loop_closure": "slam|places",
    "optimization": "optimization|refinement",
    "calibration": "refinement|slam",
    "mapping": "mapping",
    "registration": "registration",
}

# Labels that test.sh excludes, and test programs that check the sources or the package.
EXCLUDED_LABELS = "sweep|fuzz|soak|cluster|benchmark"
EXCLUDED_PROGRAMS = "structure|package"

INCLUDE = '#include "mutation.h"\n'
HEADER = """#pragma once

#include <cstdlib>

namespace surfit {

inline const int selected_mutation = [] {
  const char* const number = std::getenv("SURFIT_MUTATION");
  return number ? std::atoi(number) : 0;
}();

inline bool surfit_mutation(int number) { return selected_mutation == number; }

}  // namespace surfit

"""


def read_faults():
    """All faults in the order of the table. Their numbers start at 1."""
    table = configparser.ConfigParser(delimiters="=", comment_prefixes="#", interpolation=None)
    table.read(Path(__file__).with_name("mutations.txt"))
    faults = [{"name": name, "number": i + 1, **table[name]} for i, name in enumerate(table.sections())]
    for fault in faults:
        if fault["module"] not in MODULES:
            sys.exit(f"error: module of {fault['name']} is '{fault['module']}', must be one of: {', '.join(MODULES)}")
    return faults


def mutated(text, fault):
    """The text of a file with both versions of the code."""
    pattern = r"\s+".join(re.escape(word) for word in fault["original"].split())
    found = list(re.finditer(pattern, text))
    if len(found) != 1:
        sys.exit(f"error: original of {fault['name']} occurs {len(found)} times in {fault['file']}, must occur once")
    original, replacement = found[0].group(), fault["replacement"]
    condition = f"surfit_mutation({fault['number']})"
    if original.endswith(";"):
        both = f"{{ if ({condition}) {{ {replacement} }} else {{ {original} }} }}"
    else:
        as_type = fault.get("type", "")
        both = f"({condition} ? {as_type}({replacement}) : {as_type}({original}))"
    return text[:found[0].start()] + both + text[found[0].end():]


def mutated_files(faults):
    """The changed files of the source tree: their paths from the root, and their bytes."""
    texts = {}
    for fault in faults:
        paths = list((ROOT / "src").rglob(fault["file"]))
        if len(paths) != 1:
            sys.exit(f"error: {len(paths)} files in src are named {fault['file']}, must be one")
        path = paths[0]
        texts[path] = mutated(texts.get(path, path.read_text()), fault)
    return {path.relative_to(ROOT): (INCLUDE + text).encode() for path, text in texts.items()}


def copy_sources(source, faults):
    """Makes the mutated copy of the source tree, and returns the number of files that have changed. The other files
    keep their time stamps."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            check=True, stdout=subprocess.PIPE, text=True).stdout
    changed = mutated_files(faults)
    changed[Path("src/mutation.h")] = HEADER.encode()
    wanted = {Path(name) for name in listed.split("\0") if name and (ROOT / name).is_file()} | set(changed)
    for path in source.rglob("*"):
        relative = path.relative_to(source)
        if path.is_file() and relative.parts[0] != "build" and relative not in wanted:
            path.unlink()
    written = 0
    for relative in wanted:
        content = changed[relative] if relative in changed else (ROOT / relative).read_bytes()
        path = source / relative
        if path.is_file() and path.read_bytes() == content:
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        if relative not in changed:
            shutil.copymode(ROOT / relative, path)
        written += 1
    return written


def build(source, jobs):
    environment = {**os.environ, "CCACHE_BASEDIR": str(source), "CCACHE_NOHASHDIR": "1"}
    data = os.environ.get("SURFIT_DATA_DIR", ROOT.parent / "shared" / "data")
    for command in (["cmake", "--preset", "release", "--log-level=WARNING", f"-DSURFIT_DATA_DIR={data}"],
                    ["cmake", "--build", "--preset", "release", "--parallel", str(jobs)]):
        if subprocess.run(command, cwd=source, env=environment).returncode:
            sys.exit(f"error: {' '.join(command)} failed")


class Results:
    """File with the results of all faults."""

    def __init__(self, path):
        self.path = path
        self.of = json.loads(path.read_text()) if path.is_file() else {"faults": {}, "passed": []}

    def of_fault(self, fault):
        """The result of a fault, or None. A changed fault has no result."""
        result = self.of["faults"].get(fault["name"])
        return result if result and result["replacement"] == fault["replacement"] else None

    def save(self):
        self.path.write_text(json.dumps(self.of, indent=1))


def failed_test(source, number, arguments, jobs):
    """Name of the first test that fails with this fault, or None."""
    command = ["ctest", "--preset", "release", "--stop-on-failure", "--no-tests=ignore", "--parallel", str(jobs),
               *arguments]
    run = subprocess.run(command, cwd=source, env={**os.environ, "SURFIT_MUTATION": str(number)}, text=True,
                         stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if run.returncode == 0:
        return None
    failed = re.search(r"The following tests FAILED:\s+\d+ - (\S+)", run.stdout)
    if not failed:
        sys.exit(f"error: ctest {' '.join(arguments)} did not run the tests:\n{run.stdout[-2000:]}")
    return failed[1]


def stages(fault):
    """Arguments of ctest for each stage."""
    programs = f"^({MODULES[fault['module']]})\\."
    yield ["--tests-regex", programs, "--label-exclude", EXCLUDED_LABELS + "|slow"]
    yield ["--tests-regex", programs, "--label-exclude", EXCLUDED_LABELS, "--label-regex", "slow"]
    yield ["--exclude-regex", f"{programs}|^({EXCLUDED_PROGRAMS})\\.", "--label-exclude", EXCLUDED_LABELS]


def run_fault(fault, source, results, jobs):
    begin = time.monotonic()
    found_by = None
    for arguments in stages(fault):
        if arguments not in results.of["passed"]:
            failed = failed_test(source, 0, arguments, jobs)
            if failed:
                sys.exit(f"error: {failed} fails without a fault")
            results.of["passed"].append(arguments)
            results.save()
        found_by = failed_test(source, fault["number"], arguments, jobs)
        if found_by:
            break
    results.of["faults"][fault["name"]] = {"found_by": found_by, "replacement": fault["replacement"],
                                           "seconds": round(time.monotonic() - begin, 1)}
    results.save()


def outcome(result):
    return "not run" if result is None else f"found by {result['found_by']}" if result["found_by"] else "survived"


def print_table(faults, results):
    for fault in faults:
        print(f"{fault['module']:<13}{fault['name']:<49}{outcome(results.of_fault(fault))}")
    known = [result for result in map(results.of_fault, faults) if result]
    found = sum(bool(result["found_by"]) for result in known)
    print(f"{found} of {len(faults)} found, {len(known) - found} survived, {len(faults) - len(known)} not run")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print the faults and their results, and run nothing")
    parser.add_argument("--only", metavar="NAME|MODULE", help="run this fault or the faults of this module again")
    parser.add_argument("--build-folder", type=Path, default=ROOT / "build" / "mutate",
                        help="folder of the mutated copy and the results (default: build/mutate)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="parallel jobs (default: all processors)")
    arguments = parser.parse_args()
    faults = read_faults()
    chosen = [fault for fault in faults if arguments.only in (None, fault["name"], fault["module"])]
    if not chosen:
        sys.exit(f"error: --only is '{arguments.only}', must be a fault or a module of mutations.txt")
    folder = arguments.build_folder.resolve()
    source = folder / "source"
    source.mkdir(parents=True, exist_ok=True)
    results = Results(folder / "results.json")
    if not arguments.list:
        if copy_sources(source, faults):
            results.of["passed"] = []
        build(source, arguments.jobs)
        todo = [fault for fault in chosen if arguments.only or not results.of_fault(fault)]
        begin = time.monotonic()
        for i, fault in enumerate(todo):
            run_fault(fault, source, results, arguments.jobs)
            left_min = (time.monotonic() - begin) / (i + 1) * (len(todo) - i - 1) / 60
            print(f"[{i + 1}/{len(todo)}] {fault['name']}: {outcome(results.of_fault(fault))}, "
                  f"about {left_min:.0f} min left", flush=True)
    print_table(chosen, results)


if __name__ == "__main__":
    main()
