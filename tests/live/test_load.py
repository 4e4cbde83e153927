"""Cost of viewers: instructions without viewers, and CPU time and delay with viewers."""

import contextlib
import os
import pathlib
import re
import shutil
import statistics
import subprocess

import pytest
from live_slam import TOOL, ServedRun, StalledViewer, Viewer, run_unserved
from report_page import simulate_room

FRAMES = int(os.environ.get("SURFIT_LOAD_FRAMES", "600"))
TURNS = int(os.environ.get("SURFIT_LOAD_TURNS", "5"))
COUNTED_FRAMES = 60
FRAMES_PER_S = 30


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return simulate_room(tmp_path_factory.mktemp("load"), FRAMES)


def count_instructions(room, output, *flags):
    """Instructions of all threads, counted by Valgrind. They do not depend on other load of the machine. The run is
    many times slower, so periodic work for pages is overestimated."""
    done = subprocess.run(
        ["valgrind", "--tool=cachegrind", "--cache-sim=no", f"--cachegrind-out-file={os.devnull}", TOOL,
         f"--sequence={room}", f"--output={output}", f"--last={COUNTED_FRAMES - 1}", "--nopictures", "--threads=1",
         *flags], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return int(re.search(r"I\s+refs:\s+([\d,]+)", done.stderr).group(1).replace(",", ""))


@pytest.mark.skipif(not shutil.which("valgrind"), reason="Valgrind (valgrind) is missing")
def test_costs_little_without_viewers(room, tmp_path):
    unserved = count_instructions(room, tmp_path / "unserved")
    served = count_instructions(room, tmp_path / "served", "--serve")
    print(f"{unserved / 1e9:.3f} G instructions unserved, {100 * (served / unserved - 1):.2f} % more served")
    assert served < 1.02 * unserved


def run_watched(room, output, viewers, stalled):
    run = ServedRun(room, output)
    watching = [Viewer(run.url) for _ in range(viewers)] + [StalledViewer(run.url) for _ in range(stalled)]
    code, processor_s = run.finish()
    for viewer in watching:
        viewer.thread.join()
    assert code == 0
    return processor_s, run.summary()


def test_viewers_cost_little(room, tmp_path):
    """CPU time for viewers relative to the duration of the run, because work for viewers is periodic. The speed of a
    machine varies: each run is compared with the mean of the unwatched runs before and after it."""
    kinds = {
        "one viewer": (1, 0),
        "ten viewers, one stalled": (10, 1),
    }
    unwatched = [run_unserved(room, tmp_path / "before")]
    runs = {kind: [] for kind in kinds}
    more = {kind: [] for kind in kinds}
    for turn in range(TURNS):
        for number, (kind, (viewers, stalled)) in enumerate(kinds.items()):
            processor_s, summary = run_watched(room, tmp_path / f"{turn}_{number}", viewers, stalled)
            unwatched.append(run_unserved(room, tmp_path / f"{turn}_{number}_unwatched"))
            base_s = statistics.mean(seconds for seconds, _ in unwatched[-2:])
            runs[kind].append(summary)
            more[kind].append((processor_s - base_s) / summary["total_s"])
    median = {kind: statistics.median(shares) for kind, shares in more.items()}
    memory = {kind: statistics.median(summary["peak_rss_bytes"] for summary in of) for kind, of in runs.items()}
    memory["unwatched"] = statistics.median(summary["peak_rss_bytes"] for _, summary in unwatched)
    seconds = sorted(seconds for seconds, _ in unwatched)
    print(f"unwatched: {seconds[0]:.2f} to {seconds[-1]:.2f} s of the processor, {memory['unwatched'] / 1e6:.0f} MB")
    for kind in kinds:
        print(f"{kind}: of one core {100 * median[kind]:.1f} % more (median of "
              f"{' '.join(f'{100 * share:.1f}' for share in more[kind])}), {memory[kind] / 1e6:.0f} MB")
    summaries = [summary for _, summary in unwatched] + sum(runs.values(), [])
    assert len({summary["digest"] for summary in summaries}) == 1
    assert median["one viewer"] < 0.05
    assert median["ten viewers, one stalled"] < 0.10
    assert memory["ten viewers, one stalled"] < memory["unwatched"] + 60e6


@contextlib.contextmanager
def on_cores(cores):
    """Restricts this process and its children to these cores."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def run_offered(sequence, output, cores, viewers):
    """A run on one core with viewers on other cores. Returns pose latencies and the number of answers."""
    with on_cores({min(cores)}):
        run = ServedRun(sequence[0], output, f"--offered_fps={FRAMES_PER_S}", "--threads=1", "--noloop_closure",
                        "--nocalibrate", "--nofinal_map", *sequence[1:])
    with on_cores(cores - {min(cores)}):
        watching = [Viewer(run.url) for _ in range(viewers)]
        code, _ = run.finish()
        for viewer in watching:
            viewer.thread.join()
    assert code == 0
    summary = run.summary()
    assert summary["frames_dropped"] == 0
    return summary, [viewer.answers for viewer in watching]


@pytest.fixture(params=["room", "kitchen"])
def sequence(request, room):
    """A sequence with flags: simulated at 160 x 120 or recorded at 320 x 240 pixels."""
    if request.param == "room":
        return [room]
    data = os.environ.get("SURFIT_DATA_DIR", os.environ["SURFIT_DEFAULT_DATA_DIR"])
    kitchen = pathlib.Path(data) / "seven_scenes_kitchen"
    if not kitchen.is_dir():
        pytest.skip(f"{kitchen} is missing")
    return [kitchen, "--downsample=2", f"--last={FRAMES // 2 - 1}"]


def test_frames_are_not_delayed(sequence, tmp_path):
    """Delay by ten viewers with the request rate of ten pages, from the arrival of a frame."""
    cores = os.sched_getaffinity(0)
    if len(cores) < 2:
        pytest.skip("the run and its viewers share one core")
    # Every second frame is fused, so the median frame time is between fused and other frames.
    kinds = [("pose_latency_ms", "mean"), ("pose_latency_ms", "median"), ("latency_ms", "mean")]
    ratios = {kind: [] for kind in kinds}
    for turn in range(2 * TURNS - 1):
        unwatched, _ = run_offered(sequence, tmp_path / f"{turn}_unwatched", cores, 0)
        watched, answers = run_offered(sequence, tmp_path / f"{turn}_watched", cores, 10)
        for of, kind in kinds:
            ratios[of, kind].append(watched[of][kind] / unwatched[of][kind])
        print(f"{min(answers)} to {max(answers)} answers;", ", ".join(
            f"{of} {kind} {unwatched[of][kind]:.2f} watched {watched[of][kind]:.2f}" for of, kind in kinds))
    medians = {kind: statistics.median(of_turns) for kind, of_turns in ratios.items()}
    print(medians)
    assert max(medians.values()) < 1.05
