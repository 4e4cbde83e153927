#!/usr/bin/env python3
"""Measures the effect of a second core on a scan:

    scan_cores.py --sequence=DIR --output=DIR [--tools=build/release/tools] [--rounds=1] [FLAG...]

Scans the sequence with one core and with two cores alternately, --rounds times each, and once in one
process with surfit_slam --loop_closure. Other FLAGs are passed to surfit_scan. Prints wall time, CPU
time and ATE of each run. For scans, prints also the time with no job, one job and two jobs running;
the time without a job is the overhead of Snakemake. Wall times are unreliable on a busy machine, so
the receipts of the run with one core are also replayed by list scheduling (scan_speedup.py).
"""
import argparse
import json
import re
import resource
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import scan_speedup  # noqa: E402


def measure(command):
    """Wall time and CPU time of a program and its child processes, in seconds."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as program:
        err = program.communicate()[1]
    if program.returncode:
        sys.exit(f"error: {' '.join(command)} failed: {err[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (time.monotonic() - begin,
            after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def seconds_at_work(scan, wall_s):
    """Seconds with no running job, one job, and two or more jobs."""
    steps = []
    for path in (scan / "jobs").glob("*.json"):
        seconds = json.loads(path.read_text(encoding="utf-8"))["seconds"]
        end = path.stat().st_mtime
        steps += [(end - seconds, 1), (end, -1)]
    steps.sort()
    spent, count = [0.0, 0.0, 0.0], 0
    for (at, change), (until, _) in zip(steps, steps[1:]):
        count += change
        spent[min(count, 2)] += until - at
    spent[0] += max(0.0, wall_s - sum(spent))
    return spent


def on_paper(scan, cores):
    """Time of the jobs of a scan by list scheduling."""
    measured = scan_speedup.Scan(scan)
    jobs = scan_speedup.chain({rule: times for rule, times in measured.times.items() if times})
    return scan_speedup.replay(jobs, cores).seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sequence", required=True)
    parser.add_argument("--output", required=True, type=Path)
    parser.add_argument("--tools", default=Path("build/release/tools"), type=Path)
    parser.add_argument("--rounds", default=1, type=int)
    options, flags = parser.parse_known_args()
    if options.output.exists():
        sys.exit(f"error: {options.output} exists: scans would continue with its files, must be a new folder")
    options.output.mkdir(parents=True)
    print("| run | wall time | CPU time | ATE | no job, one, two |\n|---|---|---|---|---|")
    for number in range(options.rounds):
        for cores in (1, 2):
            scan = options.output / f"cores_{cores}_{number}"
            wall_s, cpu_s = measure([str(options.tools / "surfit_scan"), f"--sequence={options.sequence}",
                                     f"--output={scan}", f"--cores={cores}", *flags])
            spent = ", ".join(f"{seconds:.0f} s" for seconds in seconds_at_work(scan, wall_s))
            ate_m = json.loads((scan / "summary.json").read_text())["ate_rmse_m"]
            print(f"| --cores={cores} | {wall_s:.0f} s | {cpu_s:.0f} s | {1000 * ate_m:.1f} mm | {spent} |", flush=True)
    whole = options.output / "whole"
    of_run = [flag for flag in flags if not re.match("--(fragment_frames|tile_m)=", flag)]
    wall_s, cpu_s = measure([str(options.tools / "surfit_slam"), f"--sequence={options.sequence}", f"--output={whole}",
                             "--loop_closure", "--nopictures", "--threads=2", *of_run])
    ate_m = json.loads((whole / "summary.json").read_text())["ate_rmse_m"]
    print(f"| surfit_slam --loop_closure | {wall_s:.0f} s | {cpu_s:.0f} s | {1000 * ate_m:.1f} mm | |")
    one, two = (on_paper(options.output / "cores_1_0", cores) for cores in (1, 2))
    print(f"\nReplayed jobs take {one:.0f} s with one core and {two:.0f} s with two, ratio {two / one:.2f}.")


if __name__ == "__main__":
    main()
