#!/usr/bin/env python3
"""Tests the replay of tools/scripts/scan_speedup.py on graphs with known schedules:
scan_speedup_test.py SCAN_SPEEDUP"""
import importlib.util
import json
import sys
import tempfile
import unittest
from pathlib import Path

spec = importlib.util.spec_from_file_location("scan_speedup", sys.argv.pop(1))
speedup = importlib.util.module_from_spec(spec)
sys.modules["scan_speedup"] = speedup
spec.loader.exec_module(speedup)
Job = speedup.Job


class ReplayTest(unittest.TestCase):
    # a (2 s) before b (3 s), c (4 s) and d (1 s), all before e (5 s).
    GRAPH = {"a": Job(2), "b": Job(3, ["a"]), "c": Job(4, ["a"]), "d": Job(1, ["a"]),
             "e": Job(5, ["b", "c", "d"])}

    def test_one_worker_takes_the_sum(self):
        self.assertEqual(speedup.replay(self.GRAPH, 1).seconds, 15)

    def test_two_workers_take_jobs_in_the_order_of_the_list(self):
        # b 2-5, c 2-6, d 5-6, e 6-11
        self.assertEqual(speedup.replay(self.GRAPH, 2).seconds, 11)

    def test_a_path_leads_over_the_worker_that_was_not_free(self):
        graph = {"a": Job(2), "b": Job(1), "c": Job(4)}  # b 0-1, c 1-5
        found = speedup.replay(graph, 2)
        self.assertEqual(found.seconds, 5)
        self.assertEqual(found.path, ["b", "c"])

    def test_no_number_of_workers_is_faster_than_the_longest_path(self):
        found = speedup.replay(self.GRAPH, 100)
        self.assertEqual(found.seconds, 11)
        self.assertEqual(found.path, ["a", "c", "e"])

    def test_starts_take_time_and_are_no_more_than_so_many_a_second(self):
        graph = {name: Job(10) for name in "abcd"}
        self.assertEqual(speedup.replay(graph, 4, start_s=1).seconds, 11)
        # The jobs start at 0, 2, 4 and 6 s.
        self.assertEqual(speedup.replay(graph, 4, jobs_per_second=0.5).seconds, 16)


    def test_what_is_not_on_a_worker_keeps_none(self):
        graph = {"a": Job(4), "b": Job(3, on_worker=False), "c": Job(2, ["b"])}
        # a 0-4, b 0-3. c waits for the worker, but not for the start of b.
        self.assertEqual(speedup.replay(graph, 1).seconds, 6)
        self.assertEqual(speedup.replay(graph, 2, start_s=1).seconds, 6)


class LawTest(unittest.TestCase):
    """Two scans with known receipts."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def scan(self, frames, fragments, jobs):
        scan = self.folder / str(frames)
        (scan / "jobs").mkdir(parents=True)
        step = frames // fragments
        plan = {"fragments": [{"first": i * step, "last": (i + 1) * step - 1} for i in range(fragments)]}
        (scan / "plan.json").write_text(json.dumps(plan))
        for name, seconds in jobs.items():
            # Busy machine: the wall time is twice the CPU time.
            receipt = {"job": name, "exit": 0, "seconds": 2 * seconds, "cpu_seconds": seconds}
            (scan / "jobs" / f"{name}.json").write_text(json.dumps(receipt))
        return speedup.Scan(scan)

    def test_jobs_and_times_grow_as_they_did(self):
        scans = [self.scan(100, 1, {"camera": 7, "fragment_0": 3, "candidates": 2, "graph": 2, "tile_0": 5}),
                 self.scan(200, 2, {"camera": 7, "fragment_0": 3, "fragment_1": 4, "candidates": 4, "graph": 3,
                                    "link_0_1": 1, "tile_0": 5, "tile_1": 6})]
        law = speedup.Law(scans)
        self.assertEqual(law.times("camera", 400), [7])
        self.assertEqual(law.times("fragment", 400), [3, 4, 3, 4])
        self.assertEqual(law.times("link", 400), [1, 1])
        # 0 s + 0.02 s F, 1 s + 0.01 s F
        self.assertAlmostEqual(law.times("candidates", 400)[0], 8)
        self.assertAlmostEqual(law.times("graph", 400)[0], 5)
        # camera, 4 fragments, candidates, 2 links, graph, 4 tiles
        self.assertAlmostEqual(speedup.replay(law.jobs(400), 1).seconds, 7 + 14 + 8 + 2 + 5 + 22)
        self.assertAlmostEqual(speedup.replay(law.jobs(400), 9).seconds, 7 + 4 + 8 + 1 + 5 + 6)
        # Overhead of Snakemake for 1 + 4 + 1 + 2 + 1 + 4 jobs.
        self.assertAlmostEqual(speedup.replay(law.jobs(400, 0.5), 9).seconds, 31 + 6.5)

    def test_a_full_index_grows_no_more(self):
        scans = [self.scan(100, 1, {"candidates": 2, "graph": 2}), self.scan(200, 2, {"candidates": 4, "graph": 3})]
        law = speedup.Law(scans, 300)
        self.assertAlmostEqual(law.times("candidates", 250)[0], 5)
        self.assertAlmostEqual(law.times("candidates", 1000)[0], 6)
        self.assertAlmostEqual(law.times("graph", 1000)[0], 11)

    def test_three_lengths_tell_what_grows_with_the_square(self):
        square = speedup.growth([(100, 2), (200, 5), (400, 17)], (1, 2))  # 1 s + 1e-4 s F^2
        self.assertEqual(square.power, 2)
        self.assertAlmostEqual(square.at(1000), 101)
        linear = speedup.growth([(100, 2), (200, 3), (400, 5)], (1, 2))
        self.assertEqual(linear.power, 1)
        self.assertAlmostEqual(linear.at(1000), 11)

    def test_two_lengths_tell_so_where_a_line_would_begin_below_zero(self):
        self.assertEqual(speedup.growth([(100, 1), (400, 17)], (1, 2)).power, 2)
        self.assertEqual(speedup.growth([(100, 2), (400, 5)], (1, 2)).power, 1)

    def test_one_length_tells_nothing_of_growth(self):
        scan = self.scan(100, 1, {"graph": 2})
        with self.assertRaises(SystemExit):
            speedup.Law([scan, scan])


if __name__ == "__main__":
    unittest.main()
