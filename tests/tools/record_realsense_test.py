"""Runs the RealSense recorder with a fake camera, and reads the recording:
record_realsense_test.py SCRIPT FOLDER_OF_PROGRAMS"""

import pathlib
import re
import subprocess
import sys
import tempfile

# Fake pyrealsense2 with the functions of the recorder: a static D435 with 8 x 6 pixels.
CAMERA = """
import types
import numpy as np

WIDTH, HEIGHT = 8, 6
stream = types.SimpleNamespace(depth="depth", color="color")
format = types.SimpleNamespace(z16="z16", rgb8="rgb8")
distortion = types.SimpleNamespace(none=0, brown_conrady=1, inverse_brown_conrady=2)


class Stream:
    def __init__(self, focal):
        self.focal = focal

    def as_video_stream_profile(self):
        return self

    def get_intrinsics(self):
        return types.SimpleNamespace(width=WIDTH, height=HEIGHT, fx=self.focal, fy=self.focal,
                                     ppx=3.5, ppy=2.5, model=1, coeffs=[0.0] * 5)

    def get_extrinsics_to(self, other):
        # Rotation by 90 degrees about z, column-major.
        return types.SimpleNamespace(rotation=[0, 1, 0, -1, 0, 0, 0, 0, 1],
                                     translation=[0.015, 0.0, 0.0])

    def fps(self):
        return 30


class Profile:
    def get_stream(self, name):
        return Stream({"depth": 7.0, "color": 9.0}[name])

    def get_device(self):
        return self

    def first_depth_sensor(self):
        return self

    def get_depth_scale(self):
        return 0.001


class config:
    def enable_stream(self, *what):
        assert what[0] in ("depth", "color") and what[4] == 30


class Frame:
    def __init__(self, image, stamp_ms):
        self.image, self.stamp_ms = image, stamp_ms

    def get_timestamp(self):
        return self.stamp_ms

    def get_data(self):
        return self.image


class pipeline:
    count = 0

    def start(self, config):
        return Profile()

    def stop(self):
        pass

    def wait_for_frames(self):
        self.count += 1
        return self

    def get_depth_frame(self):
        depth = np.full((HEIGHT, WIDTH), 1500, np.uint16)
        return Frame(depth, 1763820000000.0 + 33.3 * self.count)

    def get_color_frame(self):
        color = np.full((HEIGHT, WIDTH, 3), 99, np.uint8)
        return Frame(color, 1763820000004.0 + 33.3 * self.count)
"""


def main():
    script, programs = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "pyrealsense2.py").write_text(CAMERA)
        recording = folder + "/recording"
        subprocess.run([sys.executable, script, recording, "--frames=3", "--width=8", "--height=6"],
                       env={"PYTHONPATH": folder}, check=True)
        read = subprocess.run(
            [programs + "/surfit_convert", "--sequence=" + recording, "--output=" + folder + "/a.klg"],
            capture_output=True, text=True, check=True)
        assert {"3", "0"} <= set(re.findall(r"\d+", read.stdout)), read.stdout
        for name in ("8 x 6", "7 7 3.5 2.5", "1000", recording + "/camera.yaml"):
            assert name in read.stderr, read.stderr
        camera = pathlib.Path(recording + "/camera.yaml").read_text()
        assert "fx: 9.0" in camera and "translation_m: [0.015, 0.0, 0.0]" in camera, camera
        rotation = camera.split("rotation_xyzw: [")[1].split("]")[0]
        quaternion = [float(number) for number in rotation.split(",")]
        sign = 1 if quaternion[3] > 0 else -1
        wanted = (0, 0, 0.5 ** 0.5, 0.5 ** 0.5)
        assert all(abs(sign * q - w) < 1e-9 for q, w in zip(quaternion, wanted)), quaternion


main()
