"""Refinement, meshes, evaluation of maps and views, pose graphs, and reports."""

import pickle

import numpy as np
import pytest

import surfit


@pytest.fixture(scope="module")
def run(room, tmp_path_factory):
    """SLAM run on the room, and its summary."""
    output = tmp_path_factory.mktemp("after") / "out"
    options = surfit.SlamRunOptions(output=output, pictures=False, threads=1)
    options.sequence.path = room
    return output, surfit.run_slam(options)


def test_a_run_is_refined(room, run):
    output, _ = run
    options = surfit.RefineRunOptions(trajectory=output / "trajectory.txt", threads=1,
                                      output=output / "refined", keyframe_translation_m=0.02)
    options.sequence.path = room
    lines = []
    summary = surfit.refine_run(options, lines.append)
    assert summary.keyframes >= 2 and lines
    assert summary.termination in ("converged", "max_rounds", "too_few_surfels", "failed")
    if summary.succeeded:
        assert (output / "refined" / "map.ply").exists()
        assert summary.calibration.camera.fx == pytest.approx(summary.given.camera.fx, rel=0.1)

    def stop(_):
        raise KeyError("stop")

    with pytest.raises(KeyError):
        surfit.refine_run(options, stop)


def test_a_map_becomes_a_mesh(run, tmp_path):
    output, summary = run
    cloud = surfit.read_point_cloud(output / "map.ply")
    stages = []
    mesh = surfit.make_mesh(cloud, surfit.MeshOptions(cell_m=0.02),
                            lambda stage, share: stages.append(share))
    assert stages == sorted(stages) and stages[-1] <= 1
    assert mesh.triangles.max() == len(mesh.vertices) - 1 and mesh.summary.pieces >= 1
    # The mesh is as large as the cloud.
    assert np.all(mesh.vertices.min(0) > cloud.points.min(0) - 0.1)
    assert np.all(mesh.vertices.max(0) < cloud.points.max(0) + 0.1)
    mesh.write(tmp_path / "mesh.ply")
    assert (tmp_path / "mesh.ply").stat().st_size > 1000
    with pytest.raises(ValueError, match="mesh.xyz"):
        mesh.write(tmp_path / "mesh.xyz")


def test_a_map_is_compared_with_a_surface(room, run):
    output, _ = run
    surface = surfit.read_point_cloud(room / "surface.ply")
    error = surfit.evaluate_map(surface.points, surface.points, surface.normals)
    assert error.accuracy_m.max == 0 and error.completeness == 1
    with pytest.raises(ValueError, match="reference_normals has 1 rows"):
        surfit.evaluate_map(surface.points, surface.points, np.zeros((1, 3)))


def test_a_map_is_evaluated_by_views(room, run):
    output, _ = run
    options = surfit.ViewEvaluationOptions(run=output, every=4, pictures=1, threads=1)
    options.sequence.path = room
    counts = []
    views = surfit.evaluate_views(options, counts.append)
    assert len(views.views) == counts[-1] and 0 < views.mean.coverage <= 1
    assert views.mean.psnr_covered_db > 10 and (output / "views.json").exists()


def turned(angle, x):
    """Rotation about z, with a translation along x."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[0, 3] = x
    return pose


def test_a_pose_graph_is_optimised(tmp_path):
    truth = [turned(0.1 * i, 0.5 * i) for i in range(5)]
    graph = surfit.PoseGraph()
    for i, pose in enumerate(truth):
        graph.add_pose(10 + i, pose if i == 0 else pose @ turned(0.05, 0.1), fixed=i == 0)
    for i in range(4):
        graph.add_edge(10 + i, 11 + i, np.linalg.inv(truth[i]) @ truth[i + 1])
    graph.add_edge(10, 14, np.linalg.inv(truth[0]) @ truth[4], 100 * np.eye(6), loop=True)
    assert graph.cost > 0.01 and graph.ids == [10, 11, 12, 13, 14] and graph.edge_count == 5
    graph.write(tmp_path / "a.g2o")
    assert surfit.PoseGraph.read(tmp_path / "a.g2o").cost == pytest.approx(graph.cost)
    summary = graph.optimize(surfit.PoseGraphOptions(start="given"))
    assert summary.succeeded and summary.final_cost < 1e-12
    assert np.allclose(graph.poses, truth, atol=1e-6)
    with pytest.raises(ValueError, match="no pose has id 3"):
        graph.add_edge(3, 10, np.eye(4))
    with pytest.raises(ValueError, match=r"information has shape \(3, 3\)"):
        graph.add_edge(10, 11, np.eye(4), np.eye(3))


def test_reports_have_repr_and_pickle(room, run):
    _, summary = run
    assert repr(summary).startswith("SlamRunSummary(frames_total=")
    kept = pickle.loads(pickle.dumps(summary))
    assert kept.digest == summary.digest
    assert kept.evaluation.ate.translation_m.rmse == summary.evaluation.ate.translation_m.rmse
    slam = surfit.Slam()
    report = slam.process(next(surfit.Sequence(room)))
    assert repr(report).startswith("FrameReport(index=0, ") and "state='first'" in repr(report)
    assert pickle.loads(pickle.dumps(report)).fusion.added == report.fusion.added


def test_sequences_list_their_assumptions(room):
    sequence = surfit.Sequence(room)
    assert sequence.assumed.startswith("format tum, ") and "camera.yaml" in sequence.assumed
    assert "format tum" in repr(sequence)
