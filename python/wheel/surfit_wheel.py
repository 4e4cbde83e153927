"""PEP 517 backend of `pip wheel .`: builds the Python package with CMake, and packs it (PEP 427).

The module contains the libraries of Surfit. Their dependencies (OpenCV, Ceres, ...) are Debian
packages, see third_party_notes.md. The Python that runs this script must have NumPy.

    pip wheel .                                                builds in build/wheel
    pip wheel . --config-settings=build-dir=build/release      packs an existing build
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Configuration for the package only. The unity build takes half the time of a normal build.
CONFIGURATION = ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
                 "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8", "-DSURFIT_BUILD_TOOLS=OFF",
                 "-DSURFIT_BUILD_TESTS=OFF", "-DSURFIT_BUILD_PYTHON=ON",
                 "-DBUILD_SHARED_LIBS=OFF", f"-DPython3_EXECUTABLE={sys.executable}"]

METADATA = """Metadata-Version: 2.1
Name: surfit
Version: {version}
Summary: {summary}
License: Apache-2.0
Requires-Python: ==3.{minor}.*
Requires-Dist: numpy
Description-Content-Type: text/markdown

{description}"""

WHEEL = """Wheel-Version: 1.0
Generator: surfit_wheel
Root-Is-Purelib: false
Tag: {tag}
"""


def cmake(*arguments):
    """Runs CMake without the PYTHONPATH of pip, which hides the installed packages."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run(["cmake", *map(str, arguments)], check=True, env=environment)


def project():
    """Version and summary of CMakeLists.txt."""
    text = (ROOT / "CMakeLists.txt").read_text()
    return re.search(r"project\(surfit VERSION (\S+)[^)]*DESCRIPTION \"([^\"]*)\"", text).groups()


def tag():
    python = f"cp3{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def built(config_settings):
    """Folder of a build with the package."""
    named = (config_settings or {}).get("build-dir")
    if named:
        return ROOT / named
    folder = ROOT / "build" / "wheel"
    cmake("-S", ROOT, "-B", folder, *CONFIGURATION)
    cmake("--build", folder, "--target", "surfit_python", "--parallel", os.cpu_count() or 1)
    return folder


def pack(files, records, wheel):
    """Writes the files by name, and then the record of their checksums."""
    rows = []
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files:
            # No modification times, so that equal files give equal wheels.
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=")
            rows.append(f"{name},sha256={digest.decode()},{len(content)}\n")
        archive.writestr(zipfile.ZipInfo(records), "".join(rows) + f"{records},,\n")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Writes the wheel into the folder and returns its name."""
    version, summary = project()
    with tempfile.TemporaryDirectory() as prefix:
        cmake("--install", built(config_settings), "--component", "python", "--strip",
              "--prefix", prefix)
        package = next(pathlib.Path(prefix).rglob("surfit/__init__.py"), None)
        if package is None:
            sys.exit("error: the build has no Python package")
        files = [(f"surfit/{path.name}", path.read_bytes())
                 for path in sorted(package.parent.iterdir())]
    about = f"surfit-{version}.dist-info"
    description = (ROOT / "README.md").read_text()
    files += [(f"{about}/METADATA",
               METADATA.format(version=version, summary=summary, minor=sys.version_info.minor,
                               description=description).encode()),
              (f"{about}/WHEEL", WHEEL.format(tag=tag()).encode())]
    files += [(f"{about}/{name}", (ROOT / name).read_bytes())
              for name in ("LICENSE", "third_party_notes.md")]
    name = f"surfit-{version}-{tag()}.whl"
    pack(files, f"{about}/RECORD", pathlib.Path(wheel_directory) / name)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("use git archive to create a source archive")
