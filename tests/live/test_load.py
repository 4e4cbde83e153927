"""What being watched costs a run: runs in turns, unwatched, served, and with viewers."""

import os
import statistics

import pytest
from live_slam import ServedRun, StalledViewer, Viewer, run_unserved
from report_page import simulate_room

FRAMES = int(os.environ.get("SURFIT_LOAD_FRAMES", "600"))
TURNS = int(os.environ.get("SURFIT_LOAD_TURNS", "5"))


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return simulate_room(tmp_path_factory.mktemp("load"), FRAMES)


def run_watched(room, output, viewers, stalled):
    run = ServedRun(room, output)
    watching = [Viewer(run.url) for _ in range(viewers)] + [StalledViewer(run.url) for _ in range(stalled)]
    code, processor_s = run.finish()
    for viewer in watching:
        viewer.thread.join()
    assert code == 0
    return processor_s, run.summary()


def test_costs_little(room, tmp_path):
    kinds = {
        "unwatched": lambda out: run_unserved(room, out),
        "served": lambda out: run_watched(room, out, 0, 0),
        "one viewer": lambda out: run_watched(room, out, 1, 0),
        "ten viewers, one stalled": lambda out: run_watched(room, out, 10, 1),
    }
    figures = {kind: [] for kind in kinds}
    for turn in range(TURNS):
        for number, (kind, start) in enumerate(kinds.items()):
            figures[kind].append(start(tmp_path / f"{turn}_{number}"))
    base = statistics.median(seconds for seconds, _ in figures["unwatched"])
    more, memory = {}, {}
    for kind, runs in figures.items():
        processor = statistics.median(seconds for seconds, _ in runs)
        wall = statistics.median(summary["total_s"] for _, summary in runs)
        more[kind] = (processor - base) / wall
        memory[kind] = statistics.median(summary["peak_rss_bytes"] for _, summary in runs)
        print(f"{kind}: processor {processor:.2f} s, {processor / base:.3f} of unwatched, of one core "
              f"{100 * more[kind]:.1f} % more, {wall:.2f} s in all, {memory[kind] / 1e6:.0f} MB")
    assert len({summary["digest"] for runs in figures.values() for _, summary in runs}) == 1
    # Of the time that the run takes: what is made for viewers keeps to the clock, not to the run's work.
    assert more["served"] < 0.02
    assert more["one viewer"] < 0.05
    assert more["ten viewers, one stalled"] < 0.10
    assert memory["ten viewers, one stalled"] < memory["unwatched"] + 60e6
