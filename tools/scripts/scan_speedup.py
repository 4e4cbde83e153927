#!/usr/bin/env python3
"""Predicts the speed-up of scans by more workers: replays the jobs of measured scans.

    scan_speedup.py SCAN SCAN... [--frames=N,...] [--workers=N,...]

SCAN: output folder of surfit_scan. All scans have the same flags, and recordings of at least two
lengths. plan.json and the receipts in jobs/ contain the number and the times of the jobs of each rule.
The time of a job is the smaller of its wall time (seconds) and its CPU time (cpu_seconds). On a busy
machine, jobs wait for each other.

Jobs of a recording of F frames:

  camera      one job of constant time: it reads only the first frames
  fragment    number proportional to F, constant time per job
  candidates  one job of a + b F^p: each keyframe is compared with all others. Constant above
              --index_frames, where the index is full (kMaxIndexBytes of surfit_scan
              --step=candidates)
  link        number proportional to F, as in the longest scan, constant time per job: each keyframe
              has at most three candidates. Short scans have fewer jobs, because few fragments
              are far enough apart
  graph       one job of a + b F: reads the frames and solves a sparse system. This is a lower bound:
              more links per frame take more time
  tile        number proportional to F, as in the longest scan, constant time per job: the camera
              always sees new places. A camera that returns has fewer tiles, which take more time
  report      one job of a + b F: reads all tiles

a and b are not negative, and are fitted to the given scans. p is 1 or 2, depending on the better fit;
1 for equal fits. A scan may lack rules, e.g. if it was stopped before its tiles. Job times are the
times of the longest scan with this rule, repeated in their order.

List scheduling: jobs start in the order in which they become ready, each on the first free worker. A
worker needs --start_s to start a job. At most --jobs_per_second jobs are started, as by the scheduler
of the profile. Snakemake needs --job_s per job in one thread, before the jobs of a rule can start.

The speed-up is the time of one worker without these overheads, divided by the total time.
"""
import argparse
import heapq
import json
import math
import sys
from dataclasses import dataclass, field
from pathlib import Path

RULES = ["camera", "fragment", "candidates", "link", "graph", "tile", "report"]
ONE_JOB = ("camera", "candidates", "graph", "report")
GROWING = {"candidates": (1, 2), "graph": (1,), "report": (1,)}  # possible powers of the number of frames


@dataclass
class Job:
    seconds: float
    after: list = field(default_factory=list)  # names of jobs that must end before
    rule: str = ""
    on_worker: bool = True  # False: starts without a worker


@dataclass
class Replay:
    seconds: float  # until the last job ends
    path: list      # critical path: names of jobs


def replay(jobs, workers, start_s=0.0, jobs_per_second=math.inf):
    """List scheduling of {name: Job} on equal workers. Names are in the order of the list."""
    position = {name: i for i, name in enumerate(jobs)}
    waits_for = {name: len(job.after) for name, job in jobs.items()}
    then = {name: [] for name in jobs}
    for name, job in jobs.items():
        for before in job.after:
            then[before].append(name)
    ready = [(0.0, position[name], name, None) for name, count in waits_for.items() if count == 0]
    heapq.heapify(ready)
    free = [(0.0, i, None) for i in range(workers)]  # time, worker, and last job of the worker
    begun = []                                       # running jobs by end time
    cause = {}
    next_start = 0.0
    end = 0.0
    last = None
    while ready or begun:
        if ready and not jobs[ready[0][2]].on_worker:
            at, _, name, by = heapq.heappop(ready)
            cause[name] = by
            heapq.heappush(begun, (at + jobs[name].seconds, position[name], name, None))
            continue
        if ready and free:
            at, _, name, by = heapq.heappop(ready)
            since, worker, former = heapq.heappop(free)
            start = max(at, since, next_start)
            next_start = start + 1 / jobs_per_second
            cause[name] = former if since > at else by
            heapq.heappush(begun, (start + start_s + jobs[name].seconds, position[name], name, worker))
            continue
        finish, _, name, worker = heapq.heappop(begun)
        if worker is not None:
            heapq.heappush(free, (finish, worker, name))
        if finish >= end:
            end, last = finish, name
        for follower in then[name]:
            waits_for[follower] -= 1
            if waits_for[follower] == 0:
                heapq.heappush(ready, (finish, position[follower], follower, name))
    path = []
    while last is not None:
        path.append(last)
        last = cause[last]
    return Replay(end, path[::-1])


def frames_of(fragments):
    """Number of frames of the recordings of these fragments."""
    ends = {}
    for fragment in fragments:
        first, last = ends.get(fragment.get("recording"), (fragment["first"], fragment["last"]))
        ends[fragment.get("recording")] = (min(first, fragment["first"]), max(last, fragment["last"]))
    return sum(last - first + 1 for first, last in ends.values())


class Scan:
    """Times of the jobs of a scan by rule, in seconds."""

    def __init__(self, folder):
        folder = Path(folder)
        plan = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
        self.fragments = len(plan["fragments"])
        self.frames = frames_of(plan["fragments"])
        self.times = {rule: [] for rule in RULES}
        for path in sorted((folder / "jobs").glob("*.json")):
            receipt = json.loads(path.read_text(encoding="utf-8"))
            rule = receipt["job"].split("_")[0]
            if receipt["exit"] == 0 and rule in self.times:
                self.times[rule].append(min(receipt["seconds"], receipt["cpu_seconds"]))


@dataclass
class Growth:
    """Seconds of the single job of a rule: start_s + per_frame_s * frames ** power."""
    start_s: float
    per_frame_s: float
    power: int
    error: float  # sum of squared residuals

    def at(self, frames):
        return self.start_s + self.per_frame_s * frames ** self.power


def fit(points, power):
    """Least-squares fit to (frames, seconds). Both terms are at least 0."""
    xs, ys = [float(frames) ** power for frames, _ in points], [seconds for _, seconds in points]
    mean_x, mean_y = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((x - mean_x) ** 2 for x in xs)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / spread
    slope = max(0.0, slope)
    if mean_y - slope * mean_x < 0:  # through the origin
        slope = sum(x * y for x, y in zip(xs, ys)) / sum(x * x for x in xs)
        mean_x = mean_y = 0.0
    start = mean_y - slope * mean_x
    return Growth(start, slope, power, sum((start + slope * x - y) ** 2 for x, y in zip(xs, ys)))


def growth(points, powers):
    """Fit with the smallest error; the first of equal fits."""
    return min((fit(points, power) for power in powers), key=lambda fitted: round(fitted.error, 9))


class Law:
    """Jobs of a scan of any length, extrapolated from measured scans."""

    def __init__(self, scans, index_frames=math.inf):
        self.longest, self.growths, self.index_frames = {}, {}, index_frames
        for rule in RULES:
            having = [scan for scan in scans if scan.times[rule]]
            if not having:
                continue
            self.longest[rule] = max(having, key=lambda scan: scan.frames)
            if rule not in GROWING:
                continue
            if len({scan.frames for scan in having}) < 2:
                sys.exit(f"error: all scans with {rule} have the same length, must be at least two lengths")
            self.growths[rule] = growth([(scan.frames, sum(scan.times[rule])) for scan in having], GROWING[rule])

    def times(self, rule, frames):
        longest = self.longest[rule]
        if rule in GROWING:
            return [self.growths[rule].at(min(frames, self.index_frames) if rule == "candidates" else frames)]
        measured = longest.times[rule]
        count = 1 if rule in ONE_JOB else max(1, round(len(measured) * frames / longest.frames))
        return [measured[i % len(measured)] for i in range(count)]

    def jobs(self, frames, job_s=0.0):
        """All jobs of a scan with this number of frames."""
        return chain({rule: self.times(rule, frames) for rule in self.longest}, job_s)


def chain(times, job_s=0.0):
    """{name: Job} from job times by rule. Jobs of a rule start after all jobs of the rule before."""
    jobs, before = {}, []
    for rule, of_rule in times.items():
        names = [f"{rule}_{i}" for i in range(len(of_rule))]
        if job_s > 0:
            jobs[f"snakemake_{rule}"] = Job(job_s * len(names), before, "snakemake", False)
            before = [f"snakemake_{rule}"]
        jobs.update({name: Job(seconds, before, rule) for name, seconds in zip(names, of_rule)})
        if len(names) > 1:  # common dependency of the next rule
            jobs[f"all_{rule}"] = Job(0.0, names, "", False)
            names = [f"all_{rule}"]
        before = names
    return jobs


def time_of_path(jobs, path):
    """Seconds of the jobs of a path by rule, longest first."""
    seconds = {}
    for name in path:
        if jobs[name].rule:
            seconds[jobs[name].rule] = seconds.get(jobs[name].rule, 0.0) + jobs[name].seconds
    return sorted(seconds.items(), key=lambda entry: -entry[1])


def duration(seconds):
    for unit, size in (("d", 86400), ("h", 3600), ("min", 60)):
        if seconds >= size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def print_laws(scans, law):
    print("| rule | " + " | ".join(f"{scan.frames} frames" for scan in scans) + " | for F frames |")
    print("|---|" + "---|" * (len(scans) + 1))
    for rule in RULES:
        cells = [f"{len(times)} x {sum(times) / len(times):.2f} s" if times else ""
                 for times in (scan.times[rule] for scan in scans)]
        grows = "constant" if rule in ONE_JOB else "number proportional to F"
        if rule in law.growths:
            found = law.growths[rule]
            grows = f"{found.start_s:.2f} s + {found.per_frame_s:.2g} s F" + ("" if found.power == 1 else "^2")
        print(f"| {rule} | " + " | ".join(cells) + f" | {grows} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    numbers = lambda text: [int(number) for number in text.split(",")]
    parser.add_argument("scans", nargs="+", metavar="SCAN")
    parser.add_argument("--frames", type=numbers, default=[10000, 100000, 1000000])
    parser.add_argument("--workers", type=numbers, default=[1, 10, 100, 1000])
    parser.add_argument("--index_frames", type=int, default=75000)
    parser.add_argument("--start_s", type=float, default=0.0)
    parser.add_argument("--jobs_per_second", type=float, default=math.inf)
    parser.add_argument("--job_s", type=float, default=0.0)
    options = parser.parse_args()
    scans = sorted((Scan(folder) for folder in options.scans), key=lambda scan: scan.frames)
    law = Law(scans, options.index_frames)
    print_laws(scans, law)
    print("\n| frames | jobs | one worker | " + " | ".join(f"{workers}" for workers in options.workers) +
          " | unlimited workers | critical path |")
    print("|---|---|---|" + "---|" * (len(options.workers) + 2))
    for frames in options.frames:
        bare = law.jobs(frames)
        alone = sum(job.seconds for job in bare.values())
        jobs = law.jobs(frames, options.job_s)
        count = sum(1 for job in bare.values() if job.rule)
        ups = []
        for workers in options.workers:
            ups.append(alone / replay(jobs, workers, options.start_s, options.jobs_per_second).seconds)
        longest = replay(jobs, len(jobs))
        path = ", ".join(f"{rule} {duration(seconds)}" for rule, seconds in time_of_path(jobs, longest.path))
        print(f"| {frames} | {count} | {duration(alone)} | " + " | ".join(f"{up:.1f}" for up in ups) +
              f" | {alone / longest.seconds:.1f} | {path} |")


if __name__ == "__main__":
    main()
