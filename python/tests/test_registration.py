"""align() and register()."""

import numpy as np
import pytest

import surfit
from conftest import run_tool


def rotation_about_y(angle_rad):
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def pose(angle_rad, translation_m):
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_about_y(angle_rad)
    matrix[:3, 3] = translation_m
    return matrix


def corner(count):
    """Exact points on three orthogonal planes, with their normals."""
    random = np.random.default_rng(3)
    points = random.uniform(0, 1, (count, 3))
    normals = np.zeros((count, 3))
    plane = np.arange(count) % 3
    points[np.arange(count), plane] = 0
    normals[np.arange(count), plane] = 1
    return points.astype(np.float32), normals.astype(np.float32)


@pytest.mark.parametrize("solver", ["closed_form_ldlt", "ceres"])
def test_register_finds_a_known_motion(solver):
    target, target_normals = corner(6000)
    source_from_target = pose(0.02, [0.01, -0.02, 0.015])
    source = target @ source_from_target[:3, :3].T + source_from_target[:3, 3]
    source_normals = target_normals @ source_from_target[:3, :3].T
    options = surfit.RegisterCloudsOptions()
    options.icp.solver = solver
    result = surfit.register(source, target, source_normals, target_normals, options=options)
    assert result.succeeded
    # Exact points: single precision has errors of 1e-6 m.
    np.testing.assert_allclose(result.target_from_source @ source_from_target, np.eye(4), atol=2e-5)
    assert result.information.shape == result.covariance.shape == (6, 6)
    assert result.inlier_ratio > 0.9


def test_register_uses_the_initial_pose_and_estimates_normals():
    target, _ = corner(6000)
    source_from_target = pose(0.6, [0.5, 0, 0.3])
    source = target @ source_from_target[:3, :3].T + source_from_target[:3, 3]
    near = pose(-0.6, [0, 0, 0])
    near[:3, 3] = -near[:3, :3] @ source_from_target[:3, 3] + 0.01
    result = surfit.register(source, target, target_from_source=near)
    assert result.succeeded
    np.testing.assert_allclose(result.target_from_source @ source_from_target, np.eye(4), atol=2e-3)


def test_register_reports_failures():
    target, normals = corner(3000)
    result = surfit.register(target + 50, target, normals, normals)
    assert not result.succeeded and result.termination == "too_few_inliers"
    with pytest.raises(ValueError, match="source: contains no finite points"):
        surfit.register(np.full((5, 3), np.nan), target)
    with pytest.raises(ValueError, match=r"target has shape \(3000, 2\), must be \(N, 3\)"):
        surfit.register(target, target[:, :2])
    with pytest.raises(ValueError, match="source_normals has 2999 rows, must have 3000"):
        surfit.register(target, target, normals[1:])


def matrix_of(row):
    """4 x 4 matrix of a row of a trajectory."""
    x, y, z, w = row[4:]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += 2 * w * cross + 2 * cross @ cross
    matrix[:3, 3] = row[1:4]
    return matrix


def test_align_finds_the_true_motion(room):
    frames = list(surfit.Sequence(room))
    truth = surfit.Sequence(room).ground_truth
    first, later = matrix_of(truth[0]), matrix_of(truth[4])
    true_motion = np.linalg.inv(first) @ later
    result = surfit.align(frames[4], frames[0])
    assert result.accepted and result.reason == "accepted"
    error = np.linalg.inv(true_motion) @ result.icp.target_from_source - np.eye(4)
    # The error is much smaller than the motion, which is the error of the identity.
    assert np.abs(error).max() < 0.1 * np.abs(true_motion - np.eye(4)).max()
    with pytest.raises(ValueError, match="method is 'luck', must be one of"):
        surfit.align(frames[4], frames[0], surfit.InitializeOptions(method="luck"))


def test_align_agrees_with_the_program(room, tmp_path):
    frames = list(surfit.Sequence(room))
    result = surfit.align(frames[5], frames[1])
    out = tmp_path / "out"
    text = run_tool("surfit_align", f"--sequence={room}", "--pair=5,1",
                    f"--output={out}")
    last = [line for line in text.splitlines() if line.startswith(result.icp.termination)][0]
    assert f"rmse {result.icp.rmse_m:.4f} m" in last


def test_point_clouds_are_read(tmp_path, room):
    slam = surfit.Slam()
    slam.process(next(surfit.Sequence(room)))
    slam.write_map(tmp_path / "map.ply")
    cloud = surfit.read_point_cloud(tmp_path / "map.ply")
    surfels = slam.surfels()
    np.testing.assert_array_equal(cloud.points, surfels.position_in_world)
    np.testing.assert_array_equal(cloud.normals, surfels.normal_in_world)
    np.testing.assert_array_equal(cloud.colors, surfels.color)
