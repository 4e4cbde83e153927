"""Surfit: dense RGB-D SLAM with surfels, on an ordinary CPU.

    import surfit
    slam = surfit.Slam()
    for frame in surfit.Sequence("living_room"):
        slam.process(frame)
    slam.write_map("map.ply")

Lengths are in metres, timestamps in seconds, and angles in radians, except for names that end in
_deg. Poses are 4 x 4 arrays a_from_b: point_in_a = a_from_b @ point_in_b. Trajectories are N x 8
arrays as in TUM files: stamp tx ty tz qx qy qz qw. Camera axes: x right, y down, z forward. Colours
are red first.

Invalid input raises ValueError with the name of the input. Other Python threads run during calls.
Ctrl-C takes effect after the current call; in run_slam() after the current frame.
"""

import warnings as _warnings

from surfit import _surfit
from surfit._surfit import *  # noqa: F401,F403
from surfit._surfit import __version__  # noqa: F401

__all__ = [name for name in dir(_surfit) if not name.startswith("_")]


def __getattr__(name):
    """Make old names of classes work until version 0.3."""
    present = _surfit._present_name(name)
    if present == name:
        raise AttributeError(f"module 'surfit' has no attribute '{name}'")
    _warnings.warn(f"{name} is an old name that version 0.3 drops: use {present}",
                   DeprecationWarning, stacklevel=2)
    return getattr(_surfit, present)
