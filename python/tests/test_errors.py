"""Invalid input raises ValueError with its name; wrong types raise TypeError."""

import warnings

import numpy as np
import pytest

import surfit

CAMERA = surfit.PinholeCamera(width=64, height=48, fx=60, fy=60, cx=31.5, cy=23.5)
DEPTH = np.ones((48, 64), np.float32)
COLOR = np.ones((48, 64, 3), np.uint8)


@pytest.mark.parametrize("color, depth, message", [
    (None, DEPTH[:40], "depth is 64 x 40 pixels, must be 64 x 48"),
    (None, DEPTH[..., None], r"depth has shape \(48, 64, 1\), must be \(height, width\)"),
    (None, DEPTH.astype(bool), "depth is of type bool, must be integer"),
    (None, np.full((48, 64), -1, np.int32), "depth has a count of -1, must be from 0 to 65535"),
    (COLOR[:, :60], DEPTH, "color is 60 x 48 pixels, must be 64 x 48"),
    (COLOR[..., 0], DEPTH, r"color has shape \(48, 64\), must be \(height, width, 3\)"),
    (COLOR.astype(np.float32), DEPTH, "color is of type float32, must be uint8"),
])
def test_arrays_must_fit_the_camera(color, depth, message):
    with pytest.raises(ValueError, match=message):
        surfit.Slam(camera=CAMERA).process(color, depth, 0.0)


def test_arrays_need_a_camera():
    with pytest.raises(ValueError, match="camera is not set"):
        surfit.Slam().process(COLOR, DEPTH, 0.0)


def test_stamps_must_be_finite():
    with pytest.raises(ValueError, match="stamp_s is nan, must be finite"):
        surfit.Frame(COLOR, DEPTH, CAMERA, stamp_s=np.nan)


def test_frames_must_keep_their_camera():
    slam = surfit.Slam(camera=CAMERA)
    other = surfit.PinholeCamera(width=64, height=48, fx=61, fy=60, cx=31.5, cy=23.5)
    with pytest.raises(ValueError, match="the frame's camera is .*fx 61.*must be .*fx 60"):
        slam.process(surfit.Frame(COLOR, DEPTH, other))


@pytest.mark.parametrize("pose, message", [
    (2 * np.eye(4), "not a rigid motion"),
    (np.diag([1, 1, -1, 1]), "not a rigid motion"),
    (np.full((4, 4), np.nan), "not a rigid motion"),
    (np.eye(3), r"pose has shape \(3, 3\), must be \(4, 4\)"),
])
def test_poses_must_be_rigid(pose, message):
    with pytest.raises(ValueError, match=message):
        surfit.Slam(initial_pose=pose)


def test_options_name_field_value_and_constraint():
    options = surfit.SlamOptions()
    options.icp.max_iterations = -1
    with pytest.raises(ValueError, match="max_iterations is -1, must be"):
        surfit.Slam(options)
    with pytest.raises(ValueError, match="tracking is 'by_magic', must be one of"):
        surfit.SlamOptions(tracking="by_magic").validate()
    with pytest.raises(ValueError, match="RobustKernel.type is 'soft', must be one of: none, "):
        options.icp.error_model.kernel.type = "soft"


def test_unknown_names_and_types():
    with pytest.raises(TypeError, match="SlamOptions has no option 'speed'"):
        surfit.SlamOptions(speed=11)
    with pytest.raises(AttributeError):
        surfit.SlamOptions().speed = 11
    with pytest.raises(TypeError):
        surfit.SlamOptions().tracking = 3
    with pytest.raises(ValueError, match="icl_nuim"):
        surfit.Slam(camera="my_camera")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(ValueError, match="nowhere"):
        surfit.Sequence(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="nothing.ply"):
        surfit.read_point_cloud(tmp_path / "nothing.ply")
    with pytest.raises(ValueError, match="no/where"):
        surfit.Slam(camera=CAMERA).write_map(tmp_path / "no/where/map.ply")


def test_unreadable_frames_are_warned_of_and_listed(room, tmp_path):
    import shutil
    path = tmp_path / "damaged"
    shutil.copytree(room, path)
    damaged = sorted((path / "depth").iterdir())[3]
    damaged.write_bytes(damaged.read_bytes()[:100])
    sequence = surfit.Sequence(path)
    with pytest.warns(RuntimeWarning, match=f"frame 3 skipped: .*{damaged.name}"):
        indices = [frame.index for frame in sequence]
    assert indices == [i for i in range(len(sequence)) if i != 3]
    assert [index for index, _ in sequence.skipped] == [3]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(RuntimeWarning):
            list(surfit.Sequence(path))
