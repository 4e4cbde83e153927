#!/usr/bin/env python3
"""Ablation of the options of SLAM: measures every field of SlamOptions by leaving it out, halving and doubling it.

ablate.py --data FOLDER --state FILE [--stage 1|2] [--fields REGEX]   measure, or continue a stopped measurement
ablate.py --state FILE --table                                        print the table of the effects

The state file has one JSON line per run. A stopped ablation continues with the first missing run.
The effect of a variant is the mean of log(ATE of the variant / ATE of the default) over recordings and starts.
Both runs of a pair have the same start. Differences below 0.1 mm are no difference. The 95 % interval is from a
bootstrap over recordings. Frames with a pose and processor time are judged as well.

Stage 1 runs groups of up to eight fields with the same variant. It halves each group that changes a result.
Stage 2 runs single fields on all recordings with three starts. Its fields are those that stage 1 has not dismissed.

Needs the Python package surfit. Simulated rooms need the programs: --tools FOLDER.
"""

import argparse
import json
import math
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time

SMALLEST_DIFFERENCE_M = 0.0001
BAND = 0.02  # an effect within this band is none
GROUP = 8
VARIANTS = ("out", "half", "double")

# name, folder, options of the sequence, options of the run
SHORT = [
    ("desk", "tum_fr1_desk", {"stride": 3, "last": 299}, {}),
    ("phone", "phone_lidar_walk", {"last": 71}, {}),
    ("d435", "realsense_d435_office", {"last": 31}, {"fit_mount": True}),
    ("room5", "room:kinect:5", {"last": 99}, {}),
]
LONG = [
    ("desk", "tum_fr1_desk", {}, {}),
    ("kitchen", "seven_scenes_kitchen", {"last": 299}, {"fit_mount": True, "truth": "groundtruth_sfm.txt"}),
    ("phone", "phone_lidar_walk", {}, {}),
    ("d435", "realsense_d435_office", {}, {"fit_mount": True}),
    ("office", "icl_office", {}, {}),
    ("office_kinect", "icl_office_kinect", {}, {}),
    ("room6", "room:kinect:6", {"last": 219}, {}),
    ("room7", "room:stereo:7", {"last": 219}, {}),
    ("room8", "room:tof:8", {"last": 219}, {}),
    ("room9", "room:lidar:9", {"last": 219}, {}),
    ("room10", "room:ideal:10", {"last": 219}, {}),
]


def fields_of(options, prefix=""):
    """Names and values of all fields of the options and of their parts."""
    fields = {}
    for name in dir(options):
        if name.startswith("_") or name == "validate":
            continue
        value = getattr(options, name)
        if isinstance(value, (bool, int, float, str)) or value is None:
            fields[prefix + name] = value
        elif hasattr(value, "validate"):
            fields.update(fields_of(value, prefix + name + "."))
    return fields


def set_field(options, path, value):
    *parts, name = path.split(".")
    for part in parts:
        options = getattr(options, part)
    setattr(options, name, value)


def choices_of(options, path):
    """Choices of a text field, from its docstring."""
    *parts, name = path.split(".")
    for part in parts:
        options = getattr(options, part)
    text = getattr(type(options), name).__doc__ or ""
    found = re.search(r"one of ([\w, ]+)$", text)
    return re.split(r", | or ", found.group(1)) if found else []


def variants_of(options, path, value):
    """Values of the variants of a field: {variant: value}."""
    if isinstance(value, bool):
        return {"out": not value}
    if isinstance(value, str):
        others = [choice for choice in choices_of(options, path) if choice != value]
        return {"out": others[0], **{other: other for other in others[1:]}} if others else {}
    if value is None or value == 0:
        return {}
    number = int if isinstance(value, int) else float
    variants = {"out": number(0), "half": number(value / 2), "double": number(value * 2)}
    return {name: changed for name, changed in variants.items() if changed != value}


def is_valid(surfit, changes):
    options = surfit.SlamRunOptions()
    try:
        for path, value in changes.items():
            set_field(options.slam, path, value)
        options.slam.validate()
    except (ValueError, TypeError, RuntimeError):
        return False
    return True


def run_here(request):
    """Runs SLAM once in this process and prints the result as JSON."""
    import surfit

    options = surfit.SlamRunOptions()
    options.sequence.path = request["path"]
    for name, value in request["sequence"].items():
        setattr(options.sequence, name, value)
    options.fit_mount = request["run"].get("fit_mount", False)
    if "truth" in request["run"]:
        options.groundtruth = os.path.join(request["path"], request["run"]["truth"])
    options.threads = 1
    options.pictures = False
    options.final_map = request["final_map"]
    for path, value in request["changes"].items():
        set_field(options.slam, path, value)
    with tempfile.TemporaryDirectory() as folder:
        options.output = folder
        surfit.run_slam(options)
        with open(os.path.join(folder, "summary.json")) as file:
            summary = json.load(file)
    usage = resource.getrusage(resource.RUSAGE_SELF)
    fitted = summary.get("fitted_mount") or {}
    print(json.dumps({
        "ate_m": fitted.get("ate_rmse_m") or summary.get("ate_rmse_m"),
        "frames": summary["frames_total"],
        "with_pose": summary.get("frames_with_pose", summary["frames_tracked"]),
        "digest": summary["digest"],
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "peak_mb": usage.ru_maxrss / 1024,
    }))


class Ablation:
    def __init__(self, arguments):
        import surfit  # the table does not need the package

        self.surfit = surfit
        self.arguments = arguments
        self.short, self.long = ([r for r in recordings if re.search(arguments.recordings, r[0])]
                                 for recordings in (SHORT, LONG))
        self.results = {}
        if os.path.exists(arguments.state):
            with open(arguments.state) as file:
                for line in file:
                    entry = json.loads(line)
                    self.results[entry["key"]] = entry
        defaults = surfit.SlamOptions()
        self.values = fields_of(defaults)
        self.variants = {path: variants_of(defaults, path, value) for path, value in self.values.items()
                         if re.search(arguments.fields, path)}

    def folder(self, name):
        if not name.startswith("room:"):
            return os.path.join(self.arguments.data, name)
        _, sensor, seed = name.split(":")
        folder = os.path.join(os.path.dirname(os.path.abspath(self.arguments.state)), f"room_{sensor}_{seed}")
        if not os.path.exists(os.path.join(folder, "groundtruth.txt")):
            simulate = os.path.join(self.arguments.tools, "surfit_simulate")
            subprocess.run([simulate, "--scene=three_rooms", "--frames=600", "--downsample=2",
                            f"--sensor={sensor}", f"--seed={seed}", f"--output={folder}"],
                           check=True, stdout=subprocess.DEVNULL)
        return folder

    def measure(self, changes, recording, first=0):
        """Result of one run, from the state file if it is there."""
        name, folder, sequence, run = recording
        key = json.dumps([changes, name, sequence, first, self.arguments.final_map], sort_keys=True)
        if key not in self.results:
            request = {"path": self.folder(folder), "sequence": {**sequence, "first": first}, "run": run,
                       "changes": changes, "final_map": self.arguments.final_map}
            done = subprocess.run([sys.executable, __file__, "--run", json.dumps(request)], capture_output=True,
                                  text=True, check=False)
            entry = {"key": key, "changes": changes, "recording": name, "first": first,
                     "stage": self.arguments.stage}
            if done.returncode == 0:
                entry.update(json.loads(done.stdout.splitlines()[-1]))
            else:
                entry["error"] = (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1]
            self.results[key] = entry
            with open(self.arguments.state, "a") as file:
                file.write(json.dumps(entry) + "\n")
        return self.results[key]

    def matters(self, changes):
        """True if the mean effect on the short recordings is beyond the band, or if a run fails or loses frames.
        Stage 2 judges the time: stage 1 may share the machine with other work."""
        effects = []
        for recording in self.short:
            default, changed = self.measure({}, recording), self.measure(changes, recording)
            if "error" in default:
                raise SystemExit(f"{recording[0]}: {default['error']}")
            if "error" in changed or changed["with_pose"] < default["with_pose"]:
                return True
            effects.append(effect_of(changed, default))
        return abs(sum(effects) / len(effects)) > BAND

    def valid(self, variant):
        """{field: value} of the fields that have the variant."""
        changes = {}
        for path, variants in self.variants.items():
            if variant in variants and is_valid(self.surfit, {path: variants[variant]}):
                changes[path] = variants[variant]
        return changes

    def bisect(self, group):
        """Fields of a group that change a result."""
        if not self.matters(group):
            return []
        if len(group) == 1:
            return list(group)
        names = list(group)
        middle = len(names) // 2
        found = []
        for half in (names[:middle], names[middle:]):
            found += self.bisect({name: group[name] for name in half})
        return found

    def groups(self):
        for variant in sorted({name for variants in self.variants.values() for name in variants},
                              key=lambda name: (name not in VARIANTS, name != "out", name)):
            changes = self.valid(variant)
            names = list(changes)
            for i in range(0, len(names), GROUP):
                group = {name: changes[name] for name in names[i:i + GROUP]}
                while len(group) > 1 and not is_valid(self.surfit, group):
                    name, value = group.popitem()
                    yield variant, {name: value}
                yield variant, group

    def stage1(self):
        groups = list(self.groups())
        begin = time.monotonic()
        for recording in self.short:
            self.measure({}, recording)
        per_run = (time.monotonic() - begin) / len(self.short)
        print(f"{sum(len(v) for v in self.variants.values())} variants of {len(self.variants)} fields, "
              f"{len(groups)} groups, about {2.5 * len(groups) * len(self.short) * per_run / 3600:.1f} h", flush=True)
        for index, (variant, group) in enumerate(groups):
            found = self.bisect(group)
            print(f"{index + 1}/{len(groups)} {variant}: {', '.join(found) or 'no effect'} of {', '.join(group)}",
                  flush=True)

    def stage2(self):
        candidates = sorted({json.dumps(entry["changes"]) for entry in self.results.values()
                             if len(entry["changes"]) == 1})
        candidates = [c for c in map(json.loads, candidates) if re.search(self.arguments.fields, next(iter(c)))]
        print(f"{len(candidates)} candidates, {3 * len(self.long) * (len(candidates) + 1)} runs", flush=True)
        for changes in [{}, *candidates]:
            for recording in self.long:
                for first in (0, 10, 20):
                    self.measure(changes, recording, first)
            print(changes, flush=True)


def effect_of(changed, default):
    """log of the ATE ratio of a pair; 0 if the difference is below the smallest one."""
    if changed.get("ate_m") is None or default.get("ate_m") is None:
        return 0.0
    if changed["digest"] == default["digest"] or abs(changed["ate_m"] - default["ate_m"]) < SMALLEST_DIFFERENCE_M:
        return 0.0
    return math.log(changed["ate_m"] / default["ate_m"])


def interval_of(effects_by_recording):
    """95 % interval of the mean effect, by a bootstrap over recordings."""
    means = [sum(effects) / len(effects) for effects in effects_by_recording.values()]
    draw = random.Random(1)
    samples = sorted(sum(draw.choice(means) for _ in means) / len(means) for _ in range(2000))
    return sum(means) / len(means), samples[50], samples[1949]


def shown(value):
    return f"{value:.4g}" if isinstance(value, float) else value


PAGE = """# Ablation

`tools/scripts/ablate.py --table` created this page. Each row changes one field of `SlamOptions`, or several fields that
together have no effect. The effect is the mean of log(ATE with the change / ATE of the default), with a 95 %% interval
from a bootstrap over recordings. Differences below 0.1 mm are no difference. "Frames" is the change in the number of
frames with a pose. The machine had other work, so times below 15 %% are no difference.

Recordings: %s.

| change | pairs | ATE | 95 %% interval | frames | time |
|---|---|---|---|---|---|"""


def table(state):
    """Prints the page: one row per field and variant, and one per group of fields without an effect."""
    with open(state) as file:
        entries = [json.loads(line) for line in file]
    defaults, variants = {}, {}
    for entry in entries:
        run = json.dumps(json.loads(entry["key"])[1:])
        if entry["changes"]:
            variants.setdefault(json.dumps(entry["changes"], sort_keys=True), []).append((run, entry))
        else:
            defaults[run] = entry
    used = sorted({f"{entry['recording']} (first frame {entry['first']}, {entry['frames']} frames)"
                   for entry in defaults.values()})
    print(PAGE % ", ".join(used))
    for text, runs in sorted(variants.items(), key=lambda item: item[0]):
        effects, lost, times, failed = {}, 0, [], 0
        for run, entry in runs:
            if run not in defaults:
                continue
            if "error" in entry:
                failed += 1
                continue
            default = defaults[run]
            effects.setdefault(entry["recording"], []).append(effect_of(entry, default))
            lost += entry["with_pose"] - default["with_pose"]
            times.append(math.log(entry["cpu_s"] / default["cpu_s"]))
        changes = json.loads(text)
        names = ", ".join(f"`{path}={shown(value)}`" for path, value in changes.items())
        if not effects:
            if failed and len(changes) == 1:
                print(f"| {names} | {failed} | fails | | | |")
            continue
        mean, low, high = (100 * (math.exp(x) - 1) for x in interval_of(effects))
        if len(changes) > 1 and (failed or lost or abs(mean) > 100 * BAND):
            continue  # its fields have their own rows
        pairs = sum(len(of_recording) for of_recording in effects.values())
        print(f"| {names} | {pairs}{f', {failed} failed' if failed else ''} | {mean:+.1f} % | "
              f"{low:+.1f} to {high:+.1f} % | {lost:+d} | {100 * (math.exp(sum(times) / len(times)) - 1):+.0f} % |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", help="folder of the recordings")
    parser.add_argument("--state", help="file with the results of all runs")
    parser.add_argument("--tools", default="build/release/tools", help="folder of the programs")
    parser.add_argument("--stage", type=int, default=1, choices=(1, 2))
    parser.add_argument("--fields", default="", help="regular expression for the fields to measure")
    parser.add_argument("--recordings", default="", help="regular expression for the recordings")
    parser.add_argument("--final_map", action="store_true", help="fuse the final map in each run")
    parser.add_argument("--table", action="store_true", help="print the table of the effects")
    parser.add_argument("--run", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.run:
        run_here(json.loads(arguments.run))
        return
    if not arguments.state or not (arguments.data or arguments.table):
        parser.error("--state and --data or --table are necessary")
    if arguments.table:
        table(arguments.state)
    elif arguments.stage == 1:
        Ablation(arguments).stage1()
    else:
        Ablation(arguments).stage2()


if __name__ == "__main__":
    main()
