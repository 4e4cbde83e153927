"""Viewers do not change the result of a run. They use little memory."""

import json
import signal

import pytest
from live_slam import ServedRun, StalledViewer, Viewer
from report_page import run_slam, simulate_room

FRAMES = 100


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return simulate_room(tmp_path_factory.mktemp("live"), FRAMES)


@pytest.fixture(scope="module")
def unwatched(room, tmp_path_factory):
    """Summary of the unwatched run."""
    run = tmp_path_factory.mktemp("unwatched")
    run_slam(room, run, "--loop_closure")
    return json.loads((run / "summary.json").read_text())


def test_ten_viewers_and_a_stalled_viewer_do_not_change_the_result(room, unwatched, tmp_path):
    run = ServedRun(room, tmp_path / "out", "--loop_closure")
    viewers = [Viewer(run.url) for _ in range(10)]
    stalled = StalledViewer(run.url)
    code, _ = run.finish()
    for viewer in [*viewers, stalled]:
        viewer.thread.join()
    assert code == 0, run.errors
    summary = run.summary()
    assert summary["digest"] == unwatched["digest"]
    assert summary["frames_total"] == FRAMES
    for viewer in viewers:
        assert viewer.is_done and viewer.answers > 50, (viewer.is_done, viewer.answers)
    # Memory of the map sample, pictures and unsent data.
    more = summary["peak_rss_bytes"] - unwatched["peak_rss_bytes"]
    print(f"{more / 1e6:.1f} MB more than unwatched, {viewers[0].bytes / 1e6:.1f} MB sent to each")
    assert more < 60e6


def test_serving_does_not_change_the_result(room, unwatched, tmp_path):
    run = ServedRun(room, tmp_path / "out", "--loop_closure")
    code, _ = run.finish()
    assert code == 0
    assert run.summary()["digest"] == unwatched["digest"]


def test_pause_step_and_stop(room, tmp_path):
    run = ServedRun(room, tmp_path / "out")
    run.post("pause")
    paused = run.wait_until(lambda state: state["paused"] and state["frames_done"] > 0)
    assert run.state()["frames_done"] == paused["frames_done"] < FRAMES
    run.post("step")
    run.wait_until(lambda state: state["frames_done"] == paused["frames_done"] + 1)
    run.post("stop")
    run.post("stop")
    code, _ = run.finish()
    assert code == 0
    assert run.summary()["interrupted"] is True
    assert (tmp_path / "out" / "map.ply").stat().st_size > 1000


def test_stops_a_run_that_ignores_ctrl_c(room, tmp_path):
    """Ignores SIGINT, like shells for background processes."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    run = ServedRun(room, tmp_path / "out")
    signal.signal(signal.SIGINT, before)
    run.post("pause")
    run.wait_until(lambda state: state["paused"] and state["frames_done"] > 0)
    run.post("stop")
    run.post("go_on")
    code, _ = run.finish()
    assert code == 0
    assert run.summary()["interrupted"] is True
