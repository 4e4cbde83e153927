"""Conversion of arrays to frames, and of maps to arrays."""

import gc

import numpy as np
import pytest

import surfit

CAMERA = surfit.PinholeCamera(width=64, height=48, fx=60, fy=60, cx=31.5, cy=23.5)


def depth_and_color():
    random = np.random.default_rng(1)
    depth = random.uniform(1, 3, (48, 64)).astype(np.float32)
    depth[0, 0] = 0
    return depth, random.integers(1, 255, (48, 64, 3), dtype=np.uint8)


def test_a_frame_contains_the_arrays():
    depth, color = depth_and_color()
    frame = surfit.Frame(color, depth, CAMERA, stamp_s=2.5, index=7)
    np.testing.assert_array_equal(frame.depth_m, depth)
    np.testing.assert_array_equal(frame.color, color)
    assert (frame.stamp_s, frame.index, frame.camera.fx) == (2.5, 7, 60)


def test_raw_depth_is_converted_to_metres():
    depth, _ = depth_and_color()
    camera = surfit.RgbdCamera(depth=CAMERA, depth_units_per_metre=1000)
    frame = surfit.Frame(None, np.rint(depth * 1000).astype(np.uint16), camera)
    np.testing.assert_allclose(frame.depth_m, depth, atol=0.5e-3 + 1e-6)
    assert frame.color is None


def test_latency_is_subtracted_from_timestamps():
    depth, color = depth_and_color()
    camera = surfit.RgbdCamera(depth=CAMERA, latency_s=0.02)
    frame = surfit.Frame(color, depth, camera, stamp_s=2.5)
    assert frame.stamp_s == frame.color_stamp_s == 2.5 - 0.02


@pytest.mark.parametrize("missing", [np.nan, np.inf, -1, 0])
def test_invalid_depth_is_missing(missing):
    depth, _ = depth_and_color()
    depth[3, 4] = missing
    assert surfit.Frame(None, depth, CAMERA).depth_m[3, 4] == 0


def test_views_ratio_memory_outlive_their_owner_and_are_read_only():
    depth, color = depth_and_color()
    frame = surfit.Frame(color, depth, CAMERA)
    first, second = frame.depth_m, frame.depth_m
    assert np.shares_memory(first, second)
    pixels = frame.color
    del frame
    gc.collect()
    np.testing.assert_array_equal(first, depth)
    np.testing.assert_array_equal(pixels, color)
    with pytest.raises(ValueError):
        first[0, 0] = 1


def test_inputs_are_copied():
    depth, color = depth_and_color()
    frame = surfit.Frame(color, depth, CAMERA)
    depth[:] = 9
    assert frame.depth_m.max() <= 3


def test_a_plane_becomes_surfels_of_the_plane():
    slam = surfit.Slam(camera=CAMERA)
    color = np.full((48, 64, 3), (200, 100, 50), np.uint8)
    report = slam.process(color, np.full((48, 64), 2, np.float32), 0.0)
    surfels = slam.surfels()
    assert len(surfels) == slam.surfel_count == report.fusion.added > 0
    assert surfels.position_in_world.shape == surfels.normal_in_world.shape == (len(surfels), 3)
    # An exact plane z = 2: single precision has errors of 1e-5 of the depth.
    np.testing.assert_allclose(surfels.position_in_world[:, 2], 2, atol=2e-5)
    np.testing.assert_allclose(surfels.normal_in_world, [[0, 0, -1]] * len(surfels), atol=1e-4)
    np.testing.assert_array_equal(surfels.color, [[200, 100, 50]] * len(surfels))
    assert surfels.first_seen.dtype == np.int32 and (surfels.last_seen == 0).all()
    assert (surfels.radius_m > 0).all() and (surfels.confidence > 0).all()


def test_depth_may_be_any_integers():
    camera = surfit.PinholeCamera(width=64, height=48, fx=60, fy=60, cx=31.5, cy=23.5)
    counts = np.arange(64 * 48, dtype=np.uint16).reshape(48, 64) + 5000
    wanted = surfit.Frame(None, counts, camera).depth_m
    for integer in (np.int32, np.int64, np.uint32):  # Pillow reads 16-bit PNG as int32
        assert np.array_equal(surfit.Frame(None, counts.astype(integer), camera).depth_m, wanted)
