#!/usr/bin/env python3
"""Creates docs/accuracy.md: the ATE of surfit_slam with default options on recordings and simulated rooms.

    tools/scripts/accuracy.py [--tools=DIR] [--output=FILE] [RECORDING...]

Each RECORDING is a folder with ground truth that surfit_slam can read. Without RECORDING, the folders with an
ABOUT.md in $SURFIT_DATA_DIR (default: ../shared/data) with at least 40 frames are measured. groundtruth_sfm.txt of a
folder is preferred over other ground truth. Each recording runs from several first frames. A run without a
result counts as a failure. With two idle cores, the recordings of ../shared/data take about ten minutes.

Requires only Python's standard library.
"""

import argparse
import datetime
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]

# ATE RMSE in mm by other systems, as their papers or later comparisons give them.
ORB_SLAM2 = "ORB-SLAM2 (Mur-Artal and Tardos 2017)"
BAD_SLAM = "BAD SLAM (Schoeps et al. 2019)"
ELASTIC_FUSION = "ElasticFusion (Whelan et al. 2015)"
BUNDLE_FUSION = "BundleFusion (Dai et al. 2017)"
DVO_SLAM = "DVO-SLAM (Kerl et al. 2013)"
RTAB_MAP = "RTAB-Map F2M (Labbe and Michaud 2019)"
MONO_GS = "MonoGS (Matsuki et al. 2024)"
RTG_SLAM = "RTG-SLAM (Peng et al. 2024)"
PUBLISHED = {
    "tum_fr1_desk": {MONO_GS: 15, ORB_SLAM2: 16, BUNDLE_FUSION: 16, BAD_SLAM: 17, RTG_SLAM: 17, ELASTIC_FUSION: 20,
                     DVO_SLAM: 21, RTAB_MAP: 29},
    "tum_fr1_desk2": {ORB_SLAM2: 22, RTAB_MAP: 44, DVO_SLAM: 46, ELASTIC_FUSION: 48},
    "tum_fr1_room": {DVO_SLAM: 43, ORB_SLAM2: 47, RTAB_MAP: 66, ELASTIC_FUSION: 68},
    "tum_fr2_xyz": {ORB_SLAM2: 4, RTAB_MAP: 5, BAD_SLAM: 11, BUNDLE_FUSION: 11, ELASTIC_FUSION: 11, DVO_SLAM: 18},
    "tum_fr3_office": {ORB_SLAM2: 10, BAD_SLAM: 17, ELASTIC_FUSION: 17, RTAB_MAP: 21, BUNDLE_FUSION: 22,
                       DVO_SLAM: 35},
}
# Public data sets with ground truth, and names that their recordings begin with.
DATA_SETS = {"TUM RGB-D": "tum_", "ICL-NUIM": "icl_", "ETH3D SLAM": "eth3d_", "Bonn RGB-D Dynamic": "bonn_",
             "7-Scenes": "seven_scenes_", "RealSense": "realsense_", "phones": "phone_"}
FEWEST_FRAMES = 40


class Progress:
    """Prints each finished run with the remaining time."""

    def __init__(self, runs):
        self.runs, self.done, self.start = runs, 0, time.monotonic()

    def report(self, name, text):
        self.done += 1
        left_s = (time.monotonic() - self.start) / self.done * (self.runs - self.done)
        print(f"[{self.done}/{self.runs}] {name}: {text}; about {left_s / 60:.0f} min left", file=sys.stderr, flush=True)


def default_recordings():
    data = pathlib.Path(os.environ.get("SURFIT_DATA_DIR", ROOT / "../shared/data"))
    return [folder.parent for folder in sorted(data.glob("*/ABOUT.md")) if len(list(folder.parent.glob("depth/*"))) +
            len(list(folder.parent.glob("*.depth.png"))) >= FEWEST_FRAMES]


def slam(tools, flags):
    """summary.json of a run of surfit_slam; None if the run wrote none."""
    with tempfile.TemporaryDirectory() as folder:
        command = [tools / "surfit_slam", *flags, "--nopictures", f"--output={folder}"]
        run = subprocess.run(command, capture_output=True, text=True)
        summary = pathlib.Path(folder) / "summary.json"
        if not summary.exists():
            print(run.stderr[-2000:], file=sys.stderr)
            return None
        return json.loads(summary.read_text(encoding="utf-8"))


def figures(summary):
    """Frames and errors of a summary; None if no pose has ground truth."""
    if summary is None or summary["ate_rmse_m"] is None:
        return None
    fitted = summary.get("ate_fit_mount_rmse_m")
    return {"frames": summary["frames_total"],
            "with_pose": summary["frames_with_pose"],
            "pieces": len(summary["pieces"]),
            "ate_mm": 1e3 * summary["ate_rmse_m"],
            "fitted_mm": None if fitted is None else 1e3 * fitted,
            "rpe_mm": 1e3 * summary["rpe_translation_rmse_m"],
            "rpe_deg": summary["rpe_rotation_rmse_deg"]}


def measure(name, variants, tools, progress):
    """The figures of each of the variants: lists of flags."""
    results = []
    for flags in variants:
        result = figures(slam(tools, flags))
        progress.report(name, f"{result['ate_mm']:.2f} mm" if result else "no result")
        results.append(result)
    return results


def sequence_flags(folder, first):
    flags = [f"--sequence={folder}", f"--first={first}", "--fit_mount"]
    if (folder / "groundtruth_sfm.txt").exists():
        flags.append(f"--groundtruth={folder}/groundtruth_sfm.txt")
    return flags


def mean(results, key, digits=1):
    values = [result[key] for result in results if result and result[key] is not None]
    return f"{statistics.mean(values):.{digits}f}" if values else "-"


def row(name, results, baseline):
    """A line of the table: a cell per column of HEADER."""
    each = [f"{result['ate_mm']:.2f}" if result else "failed" for result in results]
    poses = [f"{result['with_pose']} / {result['frames']}" if result else "-" for result in results]
    cells = [name, ", ".join(poses), str(max((result["pieces"] for result in results if result), default="-")),
             ", ".join(each), mean(results, "ate_mm", 2), mean(results, "fitted_mm", 2), mean(results, "rpe_mm"),
             mean(results, "rpe_deg", 2), mean(baseline, "ate_mm")]
    return "| " + " | ".join(cells) + " |"


HEADER = ("| recording | frames with a pose | pieces | ATE, mm | mean | mean, fitted mount | RPE, mm | RPE, degrees | "
          "frame to frame, mm |\n|---|---|---|---|---|---|---|---|---|")


def published_table(names):
    if not any(name in PUBLISHED for name in names):
        return "No measured recording has published results."
    lines = ["| recording | ATE of other systems, mm |", "|---|---|"]
    for name in names:
        if name in PUBLISHED:
            systems = ", ".join(f"{system} {ate}" for system, ate in PUBLISHED[name].items())
            lines.append(f"| {name} | {systems} |")
    return "\n".join(lines)


def not_measured(names):
    """Sentences about the recordings and data sets that have no row."""
    missing = [name for name in PUBLISHED if name not in names]
    sets = [label for label, prefix in DATA_SETS.items() if not any(name.startswith(prefix) for name in names)]
    sentences = []
    if missing:
        sentences.append(f"Recordings with published results that were not measured: {', '.join(missing)}.")
    if sets:
        sentences.append(f"Data sets without a recording on this page: {', '.join(sets)}.")
    return " ".join(sentences)


def processor():
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.exists() else []
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown processor")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tools", type=pathlib.Path, help="folder of the programs; default: they are built")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/accuracy.md")
    parser.add_argument("--starts", default="0,10,20", help="first frames of the runs of a recording")
    parser.add_argument("--rooms", type=int, default=5, help="number of simulated rooms")
    parser.add_argument("--room_frames", type=int, default=100)
    parser.add_argument("--room_downsample", type=int, default=2)
    parser.add_argument("--no_recordings", action="store_true", help="measure simulated rooms only")
    parser.add_argument("recordings", nargs="*", type=pathlib.Path, metavar="RECORDING")
    options = parser.parse_args()
    recordings = [] if options.no_recordings else options.recordings or default_recordings()
    for folder in recordings:
        if not folder.is_dir():
            parser.error(f"{folder} is not a folder")
    if not recordings and not options.no_recordings:
        parser.error("no recordings in $SURFIT_DATA_DIR")
    starts = [int(first) for first in options.starts.split(",")]
    if options.tools is None:
        build = [str(ROOT / "tools/scripts/build.sh"), "release", "surfit_slam", "surfit_simulate"]
        subprocess.run(build, check=True, stdout=sys.stderr)
        options.tools = ROOT / "build/release/tools"

    progress = Progress(len(recordings) * (len(starts) + 1) + 2 * options.rooms)
    baseline_flags = ["--tracking=frame_to_frame", "--norefine", "--nocalibrate", "--noloop_closure",
                      "--nofinal_map"]
    rows = []
    for folder in recordings:
        name = folder.resolve().name
        results = measure(name, [sequence_flags(folder, first) for first in starts], options.tools, progress)
        baseline = measure(name, [sequence_flags(folder, starts[0]) + baseline_flags], options.tools, progress)
        rows.append(row(name, results, baseline))
    rooms_command = (f"surfit_simulate --sensor=kinect --downsample={options.room_downsample} "
                     f"--frames={options.room_frames}")
    results, baseline = [], []
    for seed in range(1, options.rooms + 1):
        with tempfile.TemporaryDirectory() as folder:
            command, *flags = rooms_command.split()
            subprocess.run([options.tools / command, *flags, f"--seed={seed}", f"--output={folder}"], check=True,
                           capture_output=True)
            flags = [f"--sequence={folder}"]
            results += measure(f"room {seed}", [flags], options.tools, progress)
            baseline += measure(f"room {seed}", [flags + baseline_flags], options.tools, progress)
    if options.rooms:
        rows.append(row("simulated rooms", results, baseline))

    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    names = [folder.resolve().name for folder in recordings]
    page = f"""# Accuracy

`tools/scripts/accuracy.py` created this page on {datetime.date.today()} from commit {commit.stdout.strip() or "unknown"}.
{os.cpu_count()} processors, {processor()}.

All options have their defaults, but `--nopictures`. Each recording runs from the frames {options.starts}.
One figure per run stands in the columns "frames with a pose" and "ATE".
The ATE is that of the largest piece of a run. "Fitted mount" is the ATE after a constant offset between the
estimated and the true body is fitted (`--fit_mount`). A run without a pose with ground truth is "failed".
"Frame to frame" is the simplest baseline: `{" ".join(baseline_flags)}` from the first start.
Simulated rooms: `{rooms_command}`, seeds 1 to {options.rooms}, one run each.

{HEADER}
{chr(10).join(rows)}

## Other systems

{published_table(names)}

Results of ElasticFusion, BAD SLAM, ORB-SLAM2 and others vary between papers. The table has the best one.

{not_measured(names)}
"""
    options.output.write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
