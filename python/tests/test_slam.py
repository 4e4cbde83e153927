"""SLAM in Python compared with surfit_slam."""

import numpy as np
import pytest
from PIL import Image

import surfit
from conftest import FRAMES, run_surfit_slam, run_tool


def slam_over(sequence, slam=None):
    slam = slam or surfit.Slam()
    for frame in sequence:
        slam.process(frame)
    return slam


@pytest.fixture(scope="module")
def program(room, tmp_path_factory):
    """Output folder and summary of surfit_slam for the room, without final map."""
    output = tmp_path_factory.mktemp("program") / "out"
    return output, run_surfit_slam(room, output, "--nofinal_map")


def test_a_sequence_gives_the_programs_digest(room, program):
    slam = slam_over(surfit.Sequence(room))
    assert slam.digest == program[1]["digest"]
    assert slam.surfel_count == program[1]["map_points"]


def test_arrays_give_the_programs_digest(room, program):
    sequence = surfit.Sequence(room)
    slam = surfit.Slam(surfit.SlamOptions(), sequence.pinhole)
    for frame in sequence:
        slam.process(frame.color, frame.depth_m, frame.stamp_s)
    assert slam.digest == program[1]["digest"]


def test_counts_and_strided_arrays_give_the_programs_digest(room, program):
    sequence = surfit.Sequence(room)
    slam = surfit.Slam(camera=sequence.camera)
    for frame in sequence:
        counts = np.rint(frame.depth_m * sequence.camera.depth_units_per_metre).astype(np.uint16)
        slam.process(np.asfortranarray(frame.color), counts.T.copy().T, frame.stamp_s)
    assert slam.digest == program[1]["digest"]


def test_on_pose_is_called_for_each_frame(room, program):
    slam, told = surfit.Slam(), []
    slam.on_pose(lambda *pose: told.append(pose))
    reports = [slam.process(frame) for frame in surfit.Sequence(room)]
    assert [(index, stamp) for index, stamp, _ in told] == [(r.index, r.stamp_s) for r in reports]
    for (_, _, pose), report in zip(told, reports):
        np.testing.assert_array_equal(pose, report.world_from_camera)
    assert slam.digest == program[1]["digest"]
    slam.on_pose(None)
    slam.process(next(iter(surfit.Sequence(room))))
    assert len(told) == len(reports)


def test_exceptions_of_on_pose_are_raised_after_fusion(room):
    slam, frames = surfit.Slam(), iter(surfit.Sequence(room))
    slam.on_pose(lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        slam.process(next(frames))
    assert slam.surfel_count > 0
    slam.on_pose(lambda *_: slam.surfel_count)
    with pytest.raises(ValueError, match="must not call its Slam"):
        slam.process(next(frames))
    slam.on_pose(None)
    assert slam.process(next(frames)).state == "tracked"


@pytest.mark.parametrize("threads", [1, 2])
def test_threads_do_not_change_the_digest(room, program, threads):
    with surfit.ThreadLimit(threads):
        assert surfit.thread_count() == threads
        assert slam_over(surfit.Sequence(room)).digest == program[1]["digest"]


def test_options_reach_the_pipeline(room, tmp_path):
    options = surfit.SlamOptions(tracking="frame_to_frame")
    options.icp.gates.max_distance_m = 0.07
    options.icp.residual = "point_to_plane"
    sequence = surfit.Sequence(room, rectify=surfit.RectifyOptions(downsample=2), stride=2)
    slam = slam_over(sequence, surfit.Slam(options))
    summary = run_surfit_slam(room, tmp_path / "out", "--tracking=frame_to_frame",
                              "--max_distance_m=0.07", "--residual=point_to_plane", "--downsample=2",
                              "--stride=2")
    assert slam.digest == summary["digest"]


def test_returns_the_estimated_calibration(room, tmp_path):
    assert slam_over(surfit.Sequence(room)).calibration is None
    path = tmp_path / "tilted"
    run_tool("surfit_simulate", f"--output={path}", "--frames=120", "--downsample=2",
             "--sensor=kinect", "--sensor_settings=inverse_depth_distortion=0.03,0,0,0,0")
    slam = slam_over(surfit.Sequence(path))
    slam.finish()
    fx, fy, cx, cy, *field = slam.calibration
    assert fx == pytest.approx(262.5, rel=0.01) and fx / fy == pytest.approx(1, rel=0.005)
    assert field[1] == pytest.approx(-0.03, abs=0.01)


def test_files_of_images_with_y_up_give_the_programs_digest_and_files(tmp_path):
    path = tmp_path / "y_up"
    run_tool("surfit_simulate", f"--output={path}", "--frames=6", "--format=icl_nuim",
             "--downsample=4")
    summary = run_surfit_slam(path, tmp_path / "out")
    sequence = surfit.Sequence(path)
    assert sequence.mirrored and sequence.camera.depth.fy < 0 < sequence.pinhole.fy
    slam = surfit.Slam(camera=sequence.camera)
    for line in (path / "associations.txt").read_text().splitlines():
        stamps_and_files = line.split()
        depth, color = [np.asarray(Image.open(path / name))
                        for name in sorted(stamps_and_files[1::2])]
        slam.process(color, depth.astype(np.uint16), float(stamps_and_files[0]))
    assert slam.digest == summary["digest"]
    assert slam.mirrored
    slam.write_trajectory(tmp_path / "trajectory.txt")
    assert (tmp_path / "trajectory.txt").read_text() == (
        tmp_path / "out/trajectory.txt").read_text()


def test_writes_the_programs_files(room, program, tmp_path):
    slam = slam_over(surfit.Sequence(room))
    slam.write_trajectory(tmp_path / "trajectory.txt")
    slam.write_map(tmp_path / "map.ply")
    for name in ("trajectory.txt", "map.ply"):
        assert (tmp_path / name).read_bytes() == (program[0] / name).read_bytes()


def test_run_slam_does_what_the_program_does(room, program, tmp_path):
    options = surfit.SlamRunOptions(output=str(tmp_path / "out"), pictures=False)
    options.sequence.path = room
    states = []
    summary = surfit.run_slam(
        options, lambda state: states.append((state.frames_done, state.frames_reintegrated)))
    assert summary.digest == program[1]["digest"]
    numbers = range(1, FRAMES + 1)
    assert states[:FRAMES] == [(i, 0) for i in numbers]
    assert {done for done, _ in states[FRAMES:]} == {FRAMES}
    # The count includes fusion and colouring of the final map: a frame counts after a part of both.
    fused_anew = [fused for _, fused in states[FRAMES:]]
    assert fused_anew == sorted(fused_anew) and fused_anew[0] == 1 and fused_anew[-1] == FRAMES
    assert summary.final_map_s > 0
    assert summary.evaluation.ate.translation_m.rmse == pytest.approx(
        program[1]["ate_rmse_m"], rel=1e-12)


def test_reports_and_poses_agree(room):
    slam = surfit.Slam()
    reports = [slam.process(frame) for frame in surfit.Sequence(room)]
    assert reports[0].state == "first"
    assert all(report.state == "tracked" and report.icp.succeeded for report in reports[1:])
    assert slam.poses.shape == (FRAMES, 4, 4) and slam.trajectory.shape == (FRAMES, 8)
    np.testing.assert_array_equal(slam.poses, [report.world_from_camera for report in reports])
    np.testing.assert_array_equal(slam.trajectory[:, 1:4], slam.poses[:, :3, 3])
    assert slam.surfel_count == sum(r.fusion.added - r.fusion.removed for r in reports)


def test_fuses_along_given_poses(room, tmp_path):
    sequence = surfit.Sequence(room)
    truth = sequence.ground_truth
    start = np.eye(4)
    start[:3, 3] = 1, 2, 3
    slam = surfit.Slam(initial_pose=start)
    reports = [slam.process(frame, world_from_camera=start) for frame in sequence]
    assert {report.state for report in reports} == {"given"}
    assert len(truth) == FRAMES
    np.testing.assert_allclose(slam.poses, [start] * FRAMES, atol=1e-12)


def test_a_lost_frame_has_no_pose(room):
    slam = surfit.Slam(camera=surfit.Sequence(room).pinhole)
    frame = next(surfit.Sequence(room))
    slam.process(frame)
    report = slam.process(None, np.zeros_like(frame.depth_m), 1.0)
    assert report.state == "lost" and report.world_from_camera is None
    assert len(slam.poses) == 1


@pytest.mark.parametrize("source", ["sequence", "arrays"])
def test_recorded_office_gives_the_programs_digest(office, tmp_path, source):
    last = 20
    summary = run_surfit_slam(office, tmp_path / "out", f"--last={last}")
    sequence = surfit.Sequence(office, last=last)
    slam = surfit.Slam(camera=sequence.pinhole)
    for frame in sequence:
        if source == "sequence":
            slam.process(frame)
        else:
            slam.process(frame.color, frame.depth_m, frame.stamp_s)
    assert slam.digest == summary["digest"]
