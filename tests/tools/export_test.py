"""Exports a simulated run in all formats, and checks the files with independent readers.

    export_test.py TOOLS_DIRECTORY

A renderer of this file draws the Gaussians, and the result is compared with the images. It blends
splats in the order of depth, like 3D Gaussian splatting (Kerbl et al., SIGGRAPH 2023). The projected
covariance grows by 0.3 px^2. alpha = opacity * exp(-d^2 / 2) is at least 1/255 and at most 0.99. The
PSNR must be at least that of the splat rendering of surfit_evaluate. Only views that the map
covers completely are compared, because the rendering of surfit_evaluate extrapolates.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import zlib

try:
    import numpy as np
except ImportError:
    print("skipped: numpy is missing")
    sys.exit(77)

HARMONIC_0 = 0.28209479177387814


def read_png(path):
    """8-bit RGB image as an array of rows, columns and channels."""
    data = path.read_bytes()
    at, packed = 8, b""
    while at < len(data):
        length, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        if kind == b"IHDR":
            width, height = (int.from_bytes(data[at + k : at + k + 4], "big") for k in (8, 12))
            assert data[at + 16] == 8 and data[at + 17] == 2, f"{path} is not 8-bit RGB"
        if kind == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += 12 + length
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    rows = np.zeros((height + 1, 3 * width + 3), np.int64)
    for v in range(height):
        kind, row, above = raw[v, 0], rows[v + 1], rows[v]
        for i in range(3, 3 * width + 3):
            left, up, corner = row[i - 3], above[i], above[i - 3]
            if kind == 4:
                guess = left + up - corner
                far = [abs(guess - left), abs(guess - up), abs(guess - corner)]
                predicted = (left, up, corner)[far.index(min(far))]
            else:
                predicted = (0, left, up, (left + up) // 2)[kind]
            row[i] = (raw[v, i - 2] + predicted) & 255
    return rows[1:, 3:].reshape(height, width, 3).astype(np.float64)


def read_splats(path):
    """Columns of a binary PLY file of floats by name."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    names, count = [], 0
    for line in data[:end].decode().splitlines():
        if line.startswith("element vertex"):
            count = int(line.split()[2])
        if line.startswith("property"):
            assert line.split()[1] == "float", line
            names.append(line.split()[2])
    table = np.frombuffer(data[end:], "<f4").reshape(count, len(names)).astype(np.float64)
    return {name: table[:, i] for i, name in enumerate(names)}


def rotations(w, x, y, z):
    """Rotation matrices of quaternions, which need not be normalised."""
    w, x, y, z = np.stack([w, x, y, z]) / np.sqrt(w * w + x * x + y * y + z * z)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def draw(splats, camera, world_from_camera):
    """Image and transmittance of the splats."""
    rotation, translation = world_from_camera
    centers = np.stack([splats[k] for k in "xyz"], 1)
    points = (centers - translation) @ rotation
    scales = np.exp(np.stack([splats[f"scale_{k}"] for k in range(3)], 1))
    turns = rotation.T @ rotations(*(splats[f"rot_{k}"] for k in range(4)))
    factors = turns * scales[:, None, :]
    covariances = factors @ factors.transpose(0, 2, 1)
    colors = np.stack([splats[f"f_dc_{k}"] for k in range(3)], 1) * HARMONIC_0 + 0.5
    opacities = 1 / (1 + np.exp(-splats["opacity"]))
    width, height, fx, fy = camera["width"], camera["height"], camera["fx"], camera["fy"]
    image, through = np.zeros((height, width, 3)), np.ones((height, width))
    for i in np.argsort(points[:, 2], kind="stable"):
        x, y, z = points[i]
        if z < 0.2:
            continue
        u, v = fx * x / z + camera["cx"], fy * y / z + camera["cy"]
        if not (-50 < u < width + 50 and -50 < v < height + 50):
            continue
        jacobian = np.array([[fx / z, 0, -fx * x / z**2], [0, fy / z, -fy * y / z**2]])
        covariance = jacobian @ covariances[i] @ jacobian.T + 0.3 * np.eye(2)
        reach = 3 * np.sqrt(np.max(np.linalg.eigvalsh(covariance)))
        left, right = max(0, int(u - reach)), min(width, int(u + reach) + 2)
        top, bottom = max(0, int(v - reach)), min(height, int(v + reach) + 2)
        if left >= right or top >= bottom:
            continue
        du, dv = np.arange(left, right) - u, (np.arange(top, bottom) - v)[:, None]
        inverse = np.linalg.inv(covariance)
        power = inverse[0, 0] * du**2 + 2 * inverse[0, 1] * du * dv + inverse[1, 1] * dv**2
        alpha = np.minimum(0.99, opacities[i] * np.exp(-0.5 * power))
        alpha[alpha < 1 / 255] = 0
        window = np.s_[top:bottom, left:right]
        image[window] += (alpha * through[window])[..., None] * np.maximum(0, colors[i])
        through[window] *= 1 - alpha
    return 255 * np.clip(image, 0, 1)


def psnr(image, other):
    return 10 * np.log10(255**2 / np.mean((image - other) ** 2))


def run(tools, program, *flags):
    subprocess.run([tools / program, *flags], check=True, stdout=subprocess.DEVNULL)


def compare(sequence, output, splats):
    """Mean PSNR of the drawn splats and of the own rendering, over the covered views of views.csv."""
    poses = json.loads((output / "poses.json").read_text())
    by_frame = {row[0]: row for row in poses["poses"]}
    images = [
        sequence / line.split()[1]
        for line in (sequence / "rgb.txt").read_text().splitlines()
        if not line.startswith("#")
    ]
    own, drawn = [], []
    with open(output / "views.csv", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if float(row["coverage"]) < 0.9999:
                continue
            frame = int(row["frame"])
            _, _, tx, ty, tz, qx, qy, qz, qw = by_frame[frame]
            turn = rotations(*(np.array([q]) for q in (qw, qx, qy, qz)))[0]
            image = draw(splats, poses["camera"], (turn, np.array([tx, ty, tz])))
            drawn.append(psnr(image, read_png(images[frame])))
            own.append(float(row["psnr_db"]))
    return np.mean(drawn), np.mean(own)


def pose_of(row):
    """4 x 4 matrix of a row tx ty tz qx qy qz qw."""
    pose = np.eye(4)
    pose[:3, :3] = rotations(*(np.array([row[k]]) for k in (6, 3, 4, 5)))[0]
    pose[:3, 3] = row[:3]
    return pose


def angle_deg(a, b):
    return np.degrees(np.arccos(np.clip((np.trace(a[:3, :3].T @ b[:3, :3]) - 1) / 2, -1, 1)))


def check_upright(sequence, output, export):
    """The simulated world has z up and its floor at 0."""
    run_pose = pose_of(json.loads((output / "poses.json").read_text())["poses"][0][2:])
    lines = (sequence / "groundtruth.txt").read_text().splitlines()
    truth = pose_of([float(x) for x in next(x for x in lines if x[0] != "#").split()[1:]])
    world = json.loads((export / "export.json").read_text())["world"]
    assert world["up"] == "z" and 0 < world["gravity_sigma_deg"] < 1, world
    truth_from_export = truth @ np.linalg.inv(run_pose) @ np.linalg.inv(world["export_from_run"])
    tilt_deg = np.degrees(np.arccos(min(1, truth_from_export[2, 2])))
    height_m = (truth_from_export @ [0, 0, 0, 1])[2]
    print(f"gravity within {tilt_deg:.3f} degrees, floor at {1000 * height_m:.1f} mm")
    assert tilt_deg < 0.5 and abs(height_m) < 0.01
    gravity = json.loads((output / "summary.json").read_text())["gravity"]
    up = (truth @ np.linalg.inv(run_pose))[:3, :3] @ gravity["up_in_world"]
    assert np.degrees(np.arccos(min(1, up[2]))) < 0.5, gravity
    assert 0 < gravity["sigma_deg"] < 1, gravity


def check_transforms(output, export):
    """Poses of transforms.json are those of the run, with OpenGL axes and the applied transform."""
    run_poses = {row[0]: row for row in json.loads((output / "poses.json").read_text())["poses"]}
    transforms = json.loads((export / "transforms.json").read_text())
    applied = np.vstack([transforms["applied_transform"], [0, 0, 0, 1]])
    assert len(transforms["frames"]) == 6
    for frame in transforms["frames"]:
        assert (export / frame["file_path"]).is_file()
        assert (export / frame["depth_file_path"]).is_file()
        row = run_poses[int(pathlib.Path(frame["file_path"]).stem)]
        expected = applied @ pose_of(row[2:]) @ np.diag([1, -1, -1, 1])
        actual = np.array(frame["transform_matrix"])
        # The colour camera is estimated, within the errors of small images.
        assert np.linalg.norm(expected[:3, 3] - actual[:3, 3]) < 0.01
        assert angle_deg(expected, actual) < 0.5
        # Nothing moves in this room.
        assert "mask_path" not in frame
    assert (export / transforms["ply_file_path"]).read_bytes().startswith(b"ply\n")
    summary = json.loads((export / "export.json").read_text())
    counts = summary["registration"]
    kept = counts["too_few_surfels"] + counts["contradicting"] + counts["without_gain"]
    assert counts["registered"] + kept == len(transforms["frames"]), counts
    assert counts["contradicting"] == 0 and counts["median_change_m"] < 0.005, counts
    camera = summary["color_camera"]
    assert camera["fx"] == transforms["fl_x"] > 0


def check_colmap(export):
    """Points of the text model project to their pixels, and the binary model has the same counts."""
    rows = [x for x in (export / "sparse_text/images.txt").read_text().splitlines() if x[0:1] != "#"]
    camera = (export / "sparse_text/cameras.txt").read_text().splitlines()[-1].split()
    assert camera[1] == "PINHOLE"
    fx, fy, cx, cy = map(float, camera[4:8])
    points = {}
    for line in (export / "sparse_text/points3D.txt").read_text().splitlines():
        if line[0] != "#":
            points[int(line.split()[0])] = np.array([float(x) for x in line.split()[1:4]])
    assert len(points) > 500
    for head, places in zip(rows[0::2], rows[1::2]):
        numbers = [float(x) for x in head.split()[1:8]]
        pose = pose_of(numbers[4:7] + numbers[1:4] + numbers[0:1])
        place = np.array([float(x) for x in places.split()]).reshape(-1, 3)
        seen = np.array([points[int(k)] for k in place[:, 2]]) @ pose[:3, :3].T + pose[:3, 3]
        pixels = seen[:, :2] / seen[:, 2:] * [fx, fy] + [cx, cy]
        assert np.abs(pixels - place[:, :2]).max() < 1e-3
    binary = (export / "sparse/0/points3D.bin").read_bytes()
    assert int.from_bytes(binary[:8], "little") == len(points)


def main():
    tools = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        sequence, output = pathlib.Path(folder, "room"), pathlib.Path(folder, "run")

        def export(form, *flags):
            to = pathlib.Path(folder, form)
            run(tools, "surfit_convert", f"--run={output}", f"--to={form}", f"--output={to}", *flags)
            return to

        run(tools, "surfit_simulate", f"--output={sequence}", "--frames=24", "--downsample=4")
        run(tools, "surfit_slam", f"--sequence={sequence}", f"--output={output}", "--nocalibrate")
        check_upright(sequence, output, export("occupancy"))
        check_transforms(output, export("nerfstudio", "--images=6"))
        check_colmap(export("colmap", "--images=6"))
        run(tools, "surfit_evaluate", "--what=views", f"--run={output}", "--every=12")
        splats = read_splats(export("gaussians", "--world=run") / "splats.ply")
        drawn, own = compare(sequence, output, splats)
        print(f"PSNR {drawn:.2f} dB of the Gaussians, {own:.2f} dB of the own rendering")
        assert drawn >= own, "the Gaussians are worse than the own rendering"


if __name__ == "__main__":
    main()
