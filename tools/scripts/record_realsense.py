#!/usr/bin/env python3
"""Records a RealSense camera to a folder that surfit_slam can read: record_realsense.py FOLDER

Requires the Debian packages python3-numpy and python3-pil, and pyrealsense2 of the Intel SDK. Ctrl-C
stops the recording.

    FOLDER/depth/STAMP.png    16-bit depth images
    FOLDER/color/STAMP.png    8-bit images of the colour camera
    FOLDER/camera.yaml        factory calibration of both cameras, and their extrinsics

STAMP is the time of the sensor clock in seconds. A separate thread writes the images, so that no
frame waits for the disk.
"""

import argparse
import pathlib
import queue
import threading

import numpy as np
import pyrealsense2 as rs
from PIL import Image


def pinhole_text(intrinsics):
    """Intrinsics of a stream in the format of camera.yaml."""
    brown_conrady = (rs.distortion.brown_conrady, rs.distortion.none)
    if any(intrinsics.coeffs) and intrinsics.model not in brown_conrady:
        print(f"warning: {intrinsics.model} is not a distortion model of OpenCV: distortion is ignored")
        coefficients = [0.0] * 5
    else:
        coefficients = list(intrinsics.coeffs)
    i = intrinsics
    return (f"{{ width: {i.width}, height: {i.height}, fx: {i.fx}, fy: {i.fy}, "
            f"cx: {i.ppx}, cy: {i.ppy}, distortion: {coefficients} }}")


def quaternion_xyzw(rotation):
    """Quaternion of a rotation matrix: eigenvector of a symmetric matrix (Bar-Itzhack, 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    k = np.array([[a - e - i, b + d, c + g, h - f],
                  [b + d, e - a - i, f + h, c - g],
                  [c + g, f + h, i - a - e, d - b],
                  [h - f, c - g, d - b, a + e + i]]) / 3
    return np.linalg.eigh(k)[1][:, -1]


def camera_text(profile):
    """The camera.yaml of a running pipeline."""
    depth = profile.get_stream(rs.stream.depth).as_video_stream_profile()
    color = profile.get_stream(rs.stream.color).as_video_stream_profile()
    color_from_depth = depth.get_extrinsics_to(color)
    rotation = np.array(color_from_depth.rotation).reshape(3, 3).T  # column-major
    unit_m = profile.get_device().first_depth_sensor().get_depth_scale()
    numbers = lambda values: [float(value) for value in values]
    return "\n".join([
        "%YAML:1.0", "---",
        f"depth_camera: {pinhole_text(depth.get_intrinsics())}",
        f"color_camera: {pinhole_text(color.get_intrinsics())}",
        f"color_from_depth: {{ translation_m: {numbers(color_from_depth.translation)}, "
        f"rotation_xyzw: {numbers(quaternion_xyzw(rotation))} }}",
        f"depth_units_per_metre: {1 / unit_m:.6g}",
        f"frames_per_second: {float(depth.fps())}", ""])


def write_images(images):
    """Writes images from the queue until None."""
    for path, image in iter(images.get, None):
        Image.fromarray(image).save(path, compress_level=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=-1, help="number of frames; -1: until Ctrl-C")
    parser.add_argument("--width", type=int, default=848)
    parser.add_argument("--height", type=int, default=480)
    parser.add_argument("--fps", type=int, default=30)
    options = parser.parse_args()
    for name in ("depth", "color"):
        (options.folder / name).mkdir(parents=True)
    config = rs.config()
    size = options.width, options.height
    config.enable_stream(rs.stream.depth, *size, rs.format.z16, options.fps)
    config.enable_stream(rs.stream.color, *size, rs.format.rgb8, options.fps)
    pipeline = rs.pipeline()
    profile = pipeline.start(config)
    (options.folder / "camera.yaml").write_text(camera_text(profile))
    images = queue.Queue()
    writer = threading.Thread(target=write_images, args=(images,))
    writer.start()
    count = 0
    try:
        while count != options.frames:
            frames = pipeline.wait_for_frames()
            depth, color = frames.get_depth_frame(), frames.get_color_frame()
            if not depth or not color:
                continue
            for name, frame in (("depth", depth), ("color", color)):
                stamp_s = frame.get_timestamp() / 1000
                # A copy, because the SDK reuses the memory.
                images.put((options.folder / name / f"{stamp_s:.6f}.png",
                            np.array(frame.get_data())))
            count += 1
    except KeyboardInterrupt:
        pass
    finally:
        pipeline.stop()
        images.put(None)
        writer.join()
    print(f"{options.folder}: {count} frames; run: "
          f"surfit_slam --sequence={options.folder} --output=out")


if __name__ == "__main__":
    main()
