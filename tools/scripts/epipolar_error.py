#!/usr/bin/env python3
"""Compares poses with the epipolar geometry of colour images, without depth:

    tools/scripts/epipolar_error.py --camera=525,525,312,240 --center=-0.025,0,0 \\
        'DATA/seven_scenes_kitchen/*.color.jpg' given='DATA/seven_scenes_kitchen/*.pose.txt' \\
        found=out/trajectory.txt

The images match a pattern, sorted by name, with 30 images per second. NAME=POSES is a TUM trajectory
with timestamps relative to the first image, or a pattern of files with one 4 x 4 matrix per image.
Images with a distance of GAP frames are matched (SIFT, ratio test). RANSAC with the essential matrix
removes wrong matches. The table shows the epipolar error of the poses in pixels: the median over image
pairs of the median per pair. --camera: fx,fy,cx,cy of the colour camera. --center: position of the
colour camera in the frame of the depth camera, in metres; the poses are those of the depth camera.

If poses were estimated together with the calibration of the depth camera, the extrinsics have changed.
--fit estimates the rotation, position and focal length of the colour camera for each NAME=POSES from
every other image pair (least squares with Huber kernel). The table then shows the remaining pairs.
Requires the Debian package python3-opencv.
"""

import argparse
import glob
import sys

import cv2
import numpy as np

FPS = 30
GAPS = (20, 50, 100, 200)
STRIDE = 10
MIN_MATCHES = 40
MAX_MATCH_ERROR_PX = 3


def read_poses(path, count):
    """One (rotation, translation) per image; None without a pose."""
    files = sorted(glob.glob(path))
    if len(files) > 1:
        matrices = [np.loadtxt(file) for file in files]
        return [(m[:3, :3], m[:3, 3]) for m in matrices[:count]]
    poses = [None] * count
    for row in np.loadtxt(path):
        index = round(row[0] * FPS)
        if abs(row[0] * FPS - index) > 0.7:  # the sensor latency may be subtracted
            sys.exit(f"{path}: timestamp {row[0]} does not fit {FPS} frames per second")
        x, y, z, w = row[4:8]
        rotation = np.array(
            [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        if 0 <= index < count:
            poses[index] = (rotation, row[1:4])
    return poses


def matched_rays(a, b, camera):
    """Rays (x, y, 1) of the matched points of two images, or None."""
    (points_a, descriptors_a), (points_b, descriptors_b) = a, b
    pairs = cv2.BFMatcher().knnMatch(descriptors_a, descriptors_b, k=2)
    good = [best for best, second in pairs if best.distance < 0.7 * second.distance]
    if len(good) < MIN_MATCHES:
        return None
    focal, center = np.array(camera[:2]), np.array(camera[2:])
    rays_a = (np.float64([points_a[m.queryIdx].pt for m in good]) - center) / focal
    rays_b = (np.float64([points_b[m.trainIdx].pt for m in good]) - center) / focal
    _, mask = cv2.findEssentialMat(rays_a, rays_b, np.eye(3), method=cv2.RANSAC, prob=0.999,
                                   threshold=MAX_MATCH_ERROR_PX / camera[0])
    if mask is None or mask.sum() < MIN_MATCHES:
        return None
    kept = mask.ravel() > 0
    ones = np.ones((kept.sum(), 1))
    return np.hstack([rays_a[kept], ones]), np.hstack([rays_b[kept], ones])


def rotation_matrix(vector):
    return cv2.Rodrigues(np.asarray(vector, dtype=float))[0]


def epipolar_distances_px(pair, mount, focal):
    """Signed epipolar error of each match of a pair (rays a, rays b, poses of a and b), in pixels. `mount`
    has the rotation vector and the position of the colour camera in the depth camera. Its last value is the
    logarithm of the focal length of the colour camera, relative to `focal`."""
    rays_a, rays_b, (rotation_a, at_a), (rotation_b, at_b) = pair
    turn, center, scale = rotation_matrix(mount[:3]), mount[3:6], np.exp(-mount[6])
    rays_a, rays_b = (rays * [scale, scale, 1] for rays in (rays_a, rays_b))
    way = turn.T @ rotation_b.T @ (at_a + rotation_a @ center - at_b - rotation_b @ center)
    x, y, z = way / np.linalg.norm(way)
    relative = turn.T @ rotation_b.T @ rotation_a @ turn
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ relative
    lines_b, lines_a = rays_a @ essential.T, rays_b @ essential
    off = np.sum(rays_b * lines_b, axis=1)
    inverse = [1 / np.linalg.norm(lines[:, :2], axis=1) for lines in (lines_a, lines_b)]
    return focal / scale * off * (inverse[0] + inverse[1]) / 2


def fitted_mount(pairs, start, focal):
    """Mount with the smallest epipolar errors, by damped Gauss-Newton."""
    mount, steps = start.copy(), np.array([1e-5] * 3 + [1e-5] * 3 + [1e-5])
    pairs = [(a[::len(a) // 40 + 1], b[::len(b) // 40 + 1], *poses) for a, b, *poses in pairs]
    for _ in range(10):
        at = lambda m: np.concatenate([epipolar_distances_px(pair, m, focal) for pair in pairs])
        residuals = at(mount)
        jacobian = np.stack([(at(mount + step) - residuals) / step.max() for step in np.diag(steps)], 1)
        weights = np.minimum(1, 1 / np.maximum(np.abs(residuals), 1e-9))  # Huber, 1 px
        hessian = jacobian.T @ (weights[:, None] * jacobian)
        hessian += 1e-6 * np.diag(np.diag(hessian))
        mount -= np.linalg.solve(hessian, jacobian.T @ (weights * residuals))
    return mount


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--camera", required=True)
    parser.add_argument("--center", default="0,0,0")
    parser.add_argument("--fit", action="store_true")
    parser.add_argument("images")
    parser.add_argument("poses", nargs="+")
    options = parser.parse_args()
    camera = [float(value) for value in options.camera.split(",")]
    center = np.array([float(value) for value in options.center.split(",")])
    files = sorted(glob.glob(options.images))
    if not files:
        sys.exit(f"{options.images}: no such images")
    named = dict(argument.split("=", 1) for argument in options.poses)
    poses = {name: read_poses(path, len(files)) for name, path in named.items()}

    sift = cv2.SIFT_create(1500)
    features = {i: sift.detectAndCompute(cv2.imread(files[i], cv2.IMREAD_GRAYSCALE), None)
                for i in range(0, len(files), STRIDE)}
    matched = {gap: [] for gap in GAPS}  # indices of two images, and their matched rays
    for gap in GAPS:
        for i in range(0, len(files) - gap, STRIDE):
            if any(of[i] is None or of[i + gap] is None for of in poses.values()):
                continue
            rays = matched_rays(features[i], features[i + gap], camera)
            if rays is not None:
                matched[gap].append((i, i + gap, *rays))
    start = np.array([0, 0, 0, *center, 0])
    medians = {}
    for name, of in poses.items():
        pairs = {gap: [(rays_a, rays_b, of[a], of[b]) for a, b, rays_a, rays_b in matches]
                 for gap, matches in matched.items()}
        mount = start
        if options.fit:
            mount = fitted_mount([pair for of_gap in pairs.values() for pair in of_gap[::2]], start,
                                 camera[0])
            pairs = {gap: of_gap[1::2] for gap, of_gap in pairs.items()}
            print(f"{name}: colour camera rotated by {np.degrees(mount[:3]).round(3)} deg, at "
                  f"{mount[3:6].round(4)} m, focal length {camera[0] * np.exp(mount[6]):.1f} px")
        medians[name] = {
            gap: (len(of_gap), np.median([np.median(np.abs(epipolar_distances_px(pair, mount, camera[0])))
                                          for pair in of_gap] or [np.nan]))
            for gap, of_gap in pairs.items()}
    print("gap   pairs  " + "  ".join(f"{name:>10}" for name in poses))
    for gap in GAPS:
        count = next(iter(medians.values()))[gap][0]
        print(f"{gap:3d}  {count:6d}  " + "  ".join(f"{of[gap][1]:10.2f}" for of in medians.values()))


if __name__ == "__main__":
    main()
