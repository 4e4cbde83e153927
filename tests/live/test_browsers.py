"""Memory and CPU time of a run that ten browsers watch for ten minutes.

The viewers are ten Chromium processes, because one browser opens at most six connections to a server. They render on
the same cores as the run. With open pages they use idle CPU time (SCHED_IDLE), so they send fewer requests than ten
machines. test_viewers.py uses the maximum request rate of pages. The test compares the CPU time of both
runs. Frame times would include the delay by rendering on the same cores."""

import concurrent.futures
import contextlib
import itertools
import os
import pathlib
import shutil
import statistics
import threading
import time

import pytest
from live_slam import ServedRun
from report_page import open_browser, simulate_room

BROWSERS = 10
MINUTES = 10


def give_processor(process, policy):
    """Sets the scheduling policy of a process and its children: SCHED_OTHER is normal, SCHED_IDLE uses idle time."""
    for task in pathlib.Path(f"/proc/{process}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # the process has ended
            os.sched_setscheduler(int(task.name), policy, os.sched_param(0))
            for child in (task / "children").read_text().split():
                give_processor(child, policy)


@pytest.fixture(scope="module")
def browsers():
    with contextlib.ExitStack() as opened:
        yield [opened.enter_context(open_browser()) for _ in range(BROWSERS)]


def in_each(browsers, act):
    with concurrent.futures.ThreadPoolExecutor(BROWSERS) as pool:
        return list(pool.map(act, browsers))


@pytest.fixture
def serve():
    """Starts runs that end with the test."""
    runs = []

    def begin(*of_run):
        runs.append(ServedRun(*of_run))
        return runs[-1]
    yield begin
    for run in runs:
        run.end()


def watch(browsers, run):
    """Opens the page of the run in each browser, and counts the requests."""
    def open_page(browser):
        browser.get(run.url)
        browser.execute_script("const get = surfit.live.get; surfit.answers = 0;"
                               "surfit.live.get = (path) => (++surfit.answers, get.call(surfit.live, path))")
    in_each(browsers, open_page)
    for browser in browsers:
        give_processor(browser.service.process.pid, os.SCHED_IDLE)


def look_away(browsers):
    """Returns the number of answers and the last frame of each page."""
    for browser in browsers:
        give_processor(browser.service.process.pid, os.SCHED_OTHER)

    def leave(browser):
        seen = browser.execute_script("return [surfit.answers, surfit.live.state.frames_done]")
        browser.get("about:blank")
        return seen
    return in_each(browsers, leave)


class Feed:
    """Copies the frames of a room into a folder for --format=watch, forward and backward in a loop, at sensor rate.
    Deletes old frames."""
    PER_SECOND = 10
    KEPT = 100

    def __init__(self, room, folder):
        self.folder = pathlib.Path(folder)
        rows = [line.split() for line in (room / "associations.txt").read_text().splitlines() if line[0] != "#"]
        self.frames = [(room / color, room / depth) for _, color, _, depth in rows]
        for name in ["color", "depth"]:
            (self.folder / name).mkdir(parents=True)
        shutil.copy(room / "camera.yaml", self.folder)
        self.ends = threading.Event()
        self.thread = threading.Thread(target=self.put_all)

    def put_all(self):
        way = self.frames + self.frames[-2:0:-1]
        for i in itertools.count():
            for name, image in zip(["color", "depth"], way[i % len(way)]):
                os.link(image, self.folder / name / f"{i:06}{image.suffix}")
                if i >= self.KEPT:
                    (self.folder / name / f"{i - self.KEPT:06}{image.suffix}").unlink()
            if self.ends.wait(1 / self.PER_SECOND):
                break

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ends.set()
        self.thread.join()


def resident_mb(run):
    pages = int(pathlib.Path(f"/proc/{run.process.pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def follow_memory(watched, unwatched):
    """Additional memory of the watched run, every ten seconds."""
    begin = time.monotonic()
    more_mb = []
    for second in range(0, 60 * MINUTES + 1, 10):
        time.sleep(max(0, begin + second - time.monotonic()))
        watched_mb, unwatched_mb = resident_mb(watched), resident_mb(unwatched)
        more_mb.append(watched_mb - unwatched_mb)
        if second % 60 == 0:
            print(f"minute {second // 60}: {watched_mb:.1f} MB watched, {unwatched_mb:.1f} MB unwatched")
    return more_mb


def test_memory_is_constant_and_cpu_time_is_small(browsers, serve, tmp_path):
    """Compares the run with a simultaneous unwatched run of the same frames. The map grows in both."""
    with Feed(pathlib.Path(simulate_room(tmp_path, 160)), tmp_path / "feed") as feed:
        runs = [serve(feed.folder, tmp_path / name, "--format=watch") for name in ["watched", "unwatched"]]
        watch(browsers, runs[0])
        more_mb = follow_memory(*runs)
        done = runs[0].state()["frames_done"]
        answers, shown = zip(*look_away(browsers))
        for run in runs:
            run.post("stop")
        codes, processor_s = zip(*[run.finish() for run in runs])
    assert codes == (0, 0)
    fifth = len(more_mb) // 5
    early_mb, late_mb = (statistics.median(part) for part in [more_mb[fifth:2 * fifth], more_mb[-fifth:]])
    print(f"{early_mb:.1f} MB more where watched in the second fifth of the time, {late_mb:.1f} MB in the last; "
          f"{min(answers)} to {max(answers)} answers to each")
    share = (processor_s[0] - processor_s[1]) / runs[0].summary()["total_s"]
    print(f"{processor_s[0]:.1f} and {processor_s[1]:.1f} s of the processor: {100 * share:.1f} % of one core more")
    assert min(shown) > done - 60 * Feed.PER_SECOND, (shown, done)
    assert late_mb - early_mb < 5
    assert share < 0.10  # the bound of live.load
