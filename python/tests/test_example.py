"""The example runs as its docstring says."""

import os
import pathlib
import subprocess
import sys

import pytest

EXAMPLE = pathlib.Path(__file__).parent.parent / "examples" / "slam_folder.py"


def test_slam_over_a_folder_draws_a_picture(room, tmp_path):
    pytest.importorskip("matplotlib")
    picture = tmp_path / "picture.png"
    done = subprocess.run([sys.executable, EXAMPLE, room, picture], capture_output=True, text=True,
                          env={**os.environ, "MPLBACKEND": "Agg"})
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("frame 0: first, ")
    assert picture.stat().st_size > 10000
