"""Test of tools/scripts/ablate.py: ablate_test.py SCRIPT"""

import json
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = sys.argv.pop(1)


def entry(changes, recording, ate_m, with_pose=100, cpu_s=10.0):
    return {"key": json.dumps([changes, recording, {}, 0, False], sort_keys=True), "changes": changes,
            "recording": recording, "first": 0, "ate_m": ate_m, "frames": 100, "with_pose": with_pose, "cpu_s": cpu_s,
            "digest": f"{changes}{recording}"}


def rows_of(entries):
    with tempfile.TemporaryDirectory() as folder:
        state = os.path.join(folder, "state.jsonl")
        with open(state, "w") as file:
            file.writelines(json.dumps(e) + "\n" for e in entries)
        done = subprocess.run([sys.executable, SCRIPT, "--state", state, "--table"], check=True, capture_output=True,
                              text=True)
    rows = done.stdout.split("|---|\n")[1].splitlines()
    return [[cell.strip() for cell in row.split("|")[1:-1]] for row in rows]


class TableTest(unittest.TestCase):
    def test_effect_is_the_geometric_mean_of_ate_ratios(self):
        rows = rows_of([entry({}, "a", 0.010), entry({}, "b", 0.020), entry({"x": 1}, "a", 0.011),
                        entry({"x": 1}, "b", 0.022, with_pose=97, cpu_s=12)])
        self.assertEqual(rows, [["`x=1`", "2", "+10.0 %", "+10.0 to +10.0 %", "-3", "+10 %"]])

    def test_interval_covers_recordings_that_disagree(self):
        (row,) = rows_of([entry({}, "a", 0.010), entry({}, "b", 0.010), entry({"x": 1}, "a", 0.005),
                          entry({"x": 1}, "b", 0.020)])
        self.assertEqual(row[2:4], ["+0.0 %", "-50.0 to +100.0 %"])

    def test_differences_below_0_1_mm_are_none(self):
        (row,) = rows_of([entry({}, "a", 0.0003), entry({"x": 1}, "a", 0.00039)])
        self.assertEqual(row[2], "+0.0 %")

    def test_failed_runs_are_counted(self):
        failed = {**entry({"x": 1}, "a", None), "error": "out of memory"}
        (row,) = rows_of([entry({}, "a", 0.01), entry({}, "b", 0.01), failed, entry({"x": 1}, "b", 0.01)])
        self.assertEqual(row[1], "1, 1 failed")

    def test_groups_have_a_row_only_without_an_effect(self):
        (row,) = rows_of([entry({}, "a", 0.010), entry({"x": 1, "y": 2}, "a", 0.010),
                          entry({"x": 1, "z": 2}, "a", 0.020)])
        self.assertEqual(row[0], "`x=1`, `y=2`")


if __name__ == "__main__":
    unittest.main()
