"""What being watched costs a run: counted instructions where nobody looks, and processor time with viewers."""

import os
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


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return simulate_room(tmp_path_factory.mktemp("load"), FRAMES)


def count_instructions(room, output, *flags):
    """Of all threads, as Valgrind counts them: a machine's other work does not change them. It takes many times as
    long, and what keeps to the clock is done as many times as often: what is made for pages is overrated."""
    done = subprocess.run(
        ["valgrind", "--tool=cachegrind", "--cache-sim=no", f"--cachegrind-out-file={os.devnull}", TOOL,
         f"--sequence={room}", f"--output={output}", f"--last={COUNTED_FRAMES - 1}", "--nopictures", "--threads=1",
         *flags], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return int(re.search(r"I\s+refs:\s+([\d,]+)", done.stderr).group(1).replace(",", ""))


@pytest.mark.skipif(not shutil.which("valgrind"), reason="Valgrind (valgrind) is missing")
def test_costs_next_to_nothing_where_nobody_looks(room, tmp_path):
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
    """Of the time that the run takes: what is made for viewers keeps to the clock, not to the run's work. A machine
    grows faster and slower: each run is compared with the mean of those before and after that nobody watches."""
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
