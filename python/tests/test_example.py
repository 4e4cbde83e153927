"""The examples run as documented."""

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


def test_the_tour_writes_all_pictures(room, tmp_path):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    done = subprocess.run([sys.executable, EXAMPLE.with_name("tour.py"), room, tmp_path],
                          capture_output=True, text=True,
                          env={**os.environ, "MPLBACKEND": "Agg"})
    assert done.returncode == 0, done.stderr
    tracked, error, mesh = done.stdout.splitlines()
    assert tracked.startswith("11 of 12 frames tracked, ")
    assert float(error.split()[3]) < 15
    assert int(mesh.split()[0]) > 1000
    for name in ("frame", "time", "map", "mesh"):
        picture = pyplot.imread(tmp_path / f"{name}.png")
        assert picture.shape[0] > 200 and picture[..., :3].std() > 0.05, name
