"""Helpers of the tests: programs, a simulated room, recorded sequences."""

import json
import os
import pathlib
import subprocess

import pytest

FRAMES = 12


def run_tool(name, *flags):
    """Runs a program and returns its output."""
    tool = pathlib.Path(os.environ["SURFIT_TOOLS_DIR"]) / name
    done = subprocess.run([tool, *flags], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def run_surfit_slam(sequence, output, *flags):
    """Runs surfit_slam and returns its summary."""
    run_tool("surfit_slam", f"--sequence={sequence}", f"--output={output}", "--pictures=false",
             *flags)
    return json.loads((output / "summary.json").read_text())


@pytest.fixture(scope="session")
def room(tmp_path_factory):
    """Simulated Kinect sequence of a room, 160 x 120 pixels."""
    path = tmp_path_factory.mktemp("simulated") / "room"
    run_tool("surfit_simulate", f"--output={path}", f"--frames={FRAMES}", "--downsample=4")
    return path


@pytest.fixture(scope="session")
def office():
    """Office of ICL-NUIM: fy < 0."""
    data = os.environ.get("SURFIT_DATA_DIR") or os.environ["SURFIT_DEFAULT_DATA_DIR"]
    path = pathlib.Path(data) / "icl_office"
    if not path.is_dir():
        pytest.skip(f"no recorded sequence at {path}")
    return path
