"""The wheel, installed in an environment without Surfit."""

import os
import pathlib
import subprocess
import sys
import zipfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*command):
    """Runs a command without the package of the build, and returns its output."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                          env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Wheel of the existing build, created with pip."""
    if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode:
        pytest.skip("pip is not installed")
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-index", ROOT, "-w", folder,
        f"--config-settings=build-dir={os.environ['SURFIT_BUILD_DIR']}")
    return next(folder.glob("surfit-*.whl"))


def test_runs_in_a_separate_environment(wheel, room, tmp_path):
    """Only NumPy is from the system."""
    run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", tmp_path / "venv")
    python = tmp_path / "venv" / "bin" / "python"
    run(sys.executable, "-m", "pip", f"--python={python}", "install", "--no-index", wheel)
    text = run(python, "-I", "-c", f"""
import surfit
slam = surfit.Slam()
for frame in surfit.Sequence({str(room)!r}):
    slam.process(frame)
print(surfit.__file__, surfit.__version__, slam.surfel_count > 1000)
""")
    assert text.startswith(str(tmp_path / "venv"))
    assert text.split()[2] == "True"
    assert "surfit" in run(sys.executable, "-m", "pip", f"--python={python}", "show", "surfit")


def test_contains_the_package_with_types_and_licence(wheel):
    names = {name.split("/")[-1] for name in zipfile.ZipFile(wheel).namelist()}
    assert {"__init__.py", "__init__.pyi", "py.typed", "LICENSE", "RECORD"} <= names
