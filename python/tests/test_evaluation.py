"""evaluate() compared with surfit_evaluate and with formulas."""

import json

import numpy as np
import pytest

import surfit
from conftest import run_tool


def walk(count=50):
    """Smooth path as TUM rows."""
    t = np.arange(count) / 30
    rows = np.zeros((count, 8))
    rows[:, 0] = t
    rows[:, 1:4] = np.stack([np.sin(t), np.cos(2 * t), t], axis=1)
    rows[:, 7] = 1
    return rows


def test_a_moved_trajectory_has_no_error():
    truth = walk()
    estimate = truth.copy()
    estimate[:, 1:4] += [1, 2, 3]
    result = surfit.evaluate(truth, estimate)
    assert result.ate.translation_m.rmse < 1e-9 and result.ate.rotation_is_unique
    assert (result.matched, result.expected, result.coverage) == (50, 50, 1)
    shift = result.ate.ground_truth_from_estimate[:3, 3]
    np.testing.assert_allclose(shift, [-1, -2, -3], atol=1e-9)


def test_agrees_with_the_program(tmp_path):
    truth, estimate = walk(), walk()
    estimate[:, 1:4] += np.random.default_rng(2).normal(0, 0.01, (50, 3))
    estimate = np.delete(estimate, [7, 8], axis=0)
    paths = [tmp_path / "truth.txt", tmp_path / "estimate.txt"]
    for path, rows in zip(paths, (truth, estimate)):
        np.savetxt(path, rows, fmt="%.17g")
    options = surfit.TrajectoryEvaluationOptions()
    options.rpe.delta = 0.5
    options.rpe.delta_unit = "seconds"
    printed = json.loads(run_tool("surfit_evaluate", f"--groundtruth={paths[0]}",
                                  f"--estimate={paths[1]}", "--delta=0.5s"))
    for result in (surfit.evaluate(truth, estimate, options=options),
                   surfit.evaluate(*paths, options=options)):
        assert result.ate.translation_m.rmse == pytest.approx(printed["ate_rmse_m"], rel=1e-12)
        assert result.rpe.rotation_deg.max == pytest.approx(
            printed["rpe_rotation_max_deg"], rel=1e-9, abs=1e-9)
        assert result.coverage == pytest.approx(48 / 50)


def test_unsorted_rows_are_sorted_and_trajectories_are_read(tmp_path):
    truth = walk()
    shuffled = np.random.default_rng(1).permutation(truth)
    assert surfit.evaluate(truth, shuffled).ate.translation_m.rmse < 1e-9
    np.savetxt(tmp_path / "t.txt", shuffled, fmt="%.17g")
    np.testing.assert_allclose(surfit.read_trajectory(tmp_path / "t.txt"), truth, atol=1e-12)


def test_too_few_poses_have_no_error():
    result = surfit.evaluate(walk(), walk()[:2], [0.0, 1 / 30])
    assert result.ate is None and (result.matched, result.expected) == (2, 2)


def test_bad_rows_are_refused():
    rows = walk()
    with pytest.raises(ValueError, match=r"estimate has shape \(50, 7\), must be \(N, 8\)"):
        surfit.evaluate(rows, rows[:, :7])
    rows[4, 4:] = 0
    with pytest.raises(ValueError, match="ground_truth: row 4 must be finite numbers"):
        surfit.evaluate(rows, walk())
    with pytest.raises(ValueError, match="delta_unit is 'miles'"):
        surfit.RelativePoseErrorOptions(delta_unit="miles")
