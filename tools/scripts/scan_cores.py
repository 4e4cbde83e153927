#!/usr/bin/env python3
"""What a second core makes of a scan on this machine:

    scan_cores.py --sequence=DIR --output=DIR [--tools=build/release/tools] [--rounds=1] [FLAG...]

scans the sequence with one core and with two, in turns, --rounds times each, and once in one process
by surfit_slam with --loop_closure. Other FLAGs go to surfit_scan. Told are, for each, the time by the
clock, the processors' time, and ATE; for scans also how long two, one and no job was at work at a
time: what nobody works at is Snakemake's own. On a busy machine the clock tells little; so what the
receipts of the run with one core say is also replayed on paper (scan_speedup.py).
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
    """Seconds by the clock and of processors, of a program and all that it started."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as program:
        err = program.communicate()[1]
    if program.returncode:
        sys.exit(f"error: {' '.join(command)} failed: {err[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (time.monotonic() - begin,
            after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def seconds_at_work(scan, wall_s):
    """For how long so many jobs were at work: [none, one, two or more]."""
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
    """The time of the scan's jobs by list scheduling."""
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
        sys.exit(f"error: {options.output} exists: scans would go on with what is done there")
    options.output.mkdir(parents=True)
    print("| run | clock | processors | ATE | none, one, two at work |\n|---|---|---|---|---|")
    for number in range(options.rounds):
        for cores in (1, 2):
            scan = options.output / f"cores_{cores}_{number}"
            wall_s, cpu_s = measure([str(options.tools / "surfit_scan"), f"--sequence={options.sequence}",
                                     f"--output={scan}", f"--cores={cores}", *flags])
            spent = ", ".join(f"{seconds:.0f} s" for seconds in seconds_at_work(scan, wall_s))
            ate_m = json.loads((scan / "summary.json").read_text())["ate_rmse_m"]
            print(f"| --cores={cores} | {wall_s:.0f} s | {cpu_s:.0f} s | {1000 * ate_m:.1f} mm | {spent} |", flush=True)
    whole = options.output / "whole"
    of_run = [flag for flag in flags if not re.match("--(fragment_frames|overlap_frames|camera_frames|tile_m)=", flag)]
    wall_s, cpu_s = measure([str(options.tools / "surfit_slam"), f"--sequence={options.sequence}", f"--output={whole}",
                             "--loop_closure", "--nopictures", "--threads=2", *of_run])
    ate_m = json.loads((whole / "summary.json").read_text())["ate_rmse_m"]
    print(f"| surfit_slam --loop_closure | {wall_s:.0f} s | {cpu_s:.0f} s | {1000 * ate_m:.1f} mm | |")
    one, two = (on_paper(options.output / "cores_1_0", cores) for cores in (1, 2))
    print(f"\nOn paper the jobs take {one:.0f} s with one core and {two:.0f} s with two: {two / one:.2f} of it.")


if __name__ == "__main__":
    main()
