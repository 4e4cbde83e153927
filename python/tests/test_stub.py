"""The type stub."""

import ast
import importlib.util
import pathlib
import subprocess
import sys

import pytest

import surfit

STUB = pathlib.Path(surfit.__file__).with_name("__init__.pyi")

USE = """
import numpy as np
import surfit
options = surfit.SlamOptions(tracking="frame_to_model")
options.icp.max_iterations = 5
slam = surfit.Slam(options, "icl_nuim", initial_pose=np.eye(4))
color, depth = np.zeros((480, 640, 3), np.uint8), np.zeros((480, 640))
report: surfit.FrameReport = slam.process(color, depth, 0.5)
slam.process(next(surfit.Sequence("folder", last=3)))
print(slam.poses.shape, slam.surfels().color.dtype, surfit.evaluate("a", slam.trajectory).ate)
"""

MISUSE = """
import surfit
options = surfit.SlamOptions()
options.icp.max_iteration = 5
options.tracking = 3
"""


def test_names_everything_public():
    tree = ast.parse(STUB.read_text())
    named = {node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    assert named == set(surfit.__all__)
    assert STUB.with_name("py.typed").exists()


def check(path):
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("mypy is not installed")
    return subprocess.run([sys.executable, "-m", "mypy", "--cache-dir=/dev/null", path],
                          capture_output=True, text=True)


def test_types_of_right_use_pass(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    result = check(tmp_path / "use.py")
    assert result.returncode == 0, result.stdout


def test_types_of_wrong_use_fail(tmp_path):
    (tmp_path / "misuse.py").write_text(MISUSE)
    result = check(tmp_path / "misuse.py")
    assert 'no attribute "max_iteration"' in result.stdout or "max_iteration" in result.stdout
    assert "Incompatible types in assignment" in result.stdout


def test_the_stub_itself_passes():
    result = check(STUB)
    assert result.returncode == 0, result.stdout
