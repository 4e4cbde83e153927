"""Ctrl-C, and other threads during a call."""

import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import surfit

RUN = """
import sys, surfit
options = surfit.SlamRunOptions(output=sys.argv[2], pictures=False)
options.sequence.path = sys.argv[1]
def progress(state):
    print(state.frames_done, flush=True)
try:
    surfit.run_slam(options, progress)
except KeyboardInterrupt:
    print("interrupted")
"""

LOOP = """
import sys, surfit
slam = surfit.Slam()
try:
    for frame in surfit.Sequence(sys.argv[1]):
        slam.process(frame)
        print(frame.index, flush=True)
except KeyboardInterrupt:
    print("interrupted")
"""


FRAMES = 10000


@pytest.fixture(scope="module")
def endless_room(room, tmp_path_factory):
    """The room with repeated frames, so that each run is interrupted before its end."""
    copy = tmp_path_factory.mktemp("endless") / "room"
    shutil.copytree(room, copy)
    table = copy / "associations.txt"
    rows = [line.split() for line in table.read_text().splitlines()]
    table.write_text("".join(f"{i} {rows[i % len(rows)][1]} {i} {rows[i % len(rows)][3]}\n"
                             for i in range(FRAMES)))
    return copy


@pytest.mark.parametrize("script", [RUN, LOOP], ids=["run_slam", "loop"])
def test_ctrl_c_ends_python(endless_room, tmp_path, script):
    run = subprocess.Popen([sys.executable, "-c", script, endless_room, tmp_path / "out"],
                           stdout=subprocess.PIPE, text=True)
    run.stdout.readline()
    run.send_signal(signal.SIGINT)
    output, _ = run.communicate(timeout=60)
    assert output.splitlines()[-1] == "interrupted" and run.returncode == 0
    if script == RUN:
        poses = (tmp_path / "out/trajectory.txt").read_text().splitlines()
        assert (tmp_path / "out/map.ply").exists()
        assert 0 < len([line for line in poses if not line.startswith("#")]) < FRAMES


def test_an_exception_of_progress_ends_the_run(room, tmp_path):
    def progress(state):
        if state.frames_done == 3:
            raise LookupError("enough")
    options = surfit.SlamRunOptions(output=str(tmp_path / "out"), pictures=False)
    options.sequence.path = room
    with pytest.raises(LookupError, match="enough"):
        surfit.run_slam(options, progress)
    assert (tmp_path / "out/summary.json").exists()


def test_other_threads_run_during_a_call():
    """While register() works on a large cloud, this thread can run."""
    random = np.random.default_rng(5)
    cloud = random.uniform(0, 1, (150000, 3)).astype(np.float32)
    cloud[np.arange(len(cloud)), np.arange(len(cloud)) % 3] = 0
    done = threading.Event()
    worker = threading.Thread(target=lambda: (surfit.register(cloud, cloud), done.set()))
    worker.start()
    longest, last = 0, time.monotonic()
    began = last
    while not done.is_set():
        time.sleep(0.001)
        now = time.monotonic()
        longest, last = max(longest, now - last), now
    worker.join()
    # If register() did not release the GIL, there would be one pause of nearly the whole time.
    assert longest < 0.5 * (last - began)


def test_one_slam_serves_several_threads(room):
    frames = list(surfit.Sequence(room))
    slam = surfit.Slam()
    slam.process(frames[0])
    threads = [threading.Thread(target=slam.process, args=(frames[0],)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(slam.poses) == 5
