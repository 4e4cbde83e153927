"""Type stub of the package."""

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


@pytest.fixture(scope="module")
def check(tmp_path_factory):
    """Runs mypy on a file, and returns its exit code and its output."""
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("mypy is not installed")
    cache = tmp_path_factory.mktemp("cache")

    def run(path):
        done = subprocess.run([sys.executable, "-m", "mypy", f"--cache-dir={cache}", path],
                              capture_output=True, text=True)
        return done.returncode, done.stdout
    return run


def test_types_of_right_use_pass(check, tmp_path):
    (tmp_path / "use.py").write_text(USE)
    code, text = check(tmp_path / "use.py")
    assert code == 0, text


def test_types_of_wrong_use_fail(check, tmp_path):
    (tmp_path / "misuse.py").write_text(MISUSE)
    _, text = check(tmp_path / "misuse.py")
    assert '"IcpOptions" has no attribute "max_iteration"' in text
    assert 'expression has type "int", variable has type "str"' in text


def test_the_stub_itself_passes(check):
    code, text = check(STUB)
    assert code == 0, text
