"""Options are attributes, complete and documented."""

import copy
import inspect
import pickle

import pytest

import surfit

CLASSES = [cls for name, cls in vars(surfit).items()
           if inspect.isclass(cls) and (name.endswith(("Options", "Camera", "Gates", "Model"))
                                        or name in ("DepthNoise", "RobustKernel"))]


def properties(cls):
    return {name: member for name, member in vars(cls).items() if isinstance(member, property)}


def test_classes_include_the_main_options():
    assert {surfit.SlamOptions, surfit.IcpOptions, surfit.FusionOptions,
            surfit.SequenceOptions, surfit.PinholeCamera} <= set(CLASSES)


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_attributes_are_documented_and_settable(cls):
    options = cls()
    assert cls.__doc__ and properties(cls)
    for name, member in properties(cls).items():
        assert member.__doc__, name
        value = getattr(options, name)
        setattr(options, name, value)
        assert repr(getattr(options, name)) == repr(value), name
    assert repr(options).startswith(cls.__name__ + "(")


def test_everything_public_is_documented():
    for name in surfit.__all__:
        member = getattr(surfit, name)
        assert member.__module__ == "surfit" and member.__doc__, name
        if inspect.isclass(member):
            assert all(p.__doc__ for p in properties(member).values()), name


def test_nested_options_are_references_and_copies_are_not():
    options = surfit.SlamOptions()
    options.icp.error_model.kernel.width = 4.5
    other = copy.deepcopy(options)
    other.icp.error_model.kernel.width = 1
    assert options.icp.error_model.kernel.width == 4.5
    assert "width=4.5" in repr(options)


def test_slam_copies_its_options(room):
    options = surfit.SlamOptions()
    slam = surfit.Slam(options)
    options.tracking = "by_magic"
    for frame in surfit.Sequence(room, last=1):
        assert slam.process(frame).state in ("first", "tracked")


def test_optional_fields_are_none_or_values():
    options = surfit.SequenceOptions(intrinsics=[1, 2, 3, 4])
    assert options.intrinsics == [1, 2, 3, 4] and options.distortion is None
    with pytest.raises(TypeError):
        options.intrinsics = [1, 2, 3]


def test_bad_values_are_refused_at_construction():
    with pytest.raises(ValueError, match="SlamOptions.tracking is 'x', must be one of: "):
        surfit.SlamOptions(tracking="x")
    with pytest.raises(ValueError, match="IcpOptions.max_iterations is -1, must be "):
        surfit.IcpOptions(max_iterations=-1)
    surfit.SlamRunOptions(threads=1)  # required options can be set later


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_pickle_keeps_all(cls):
    options = cls()
    assert repr(pickle.loads(pickle.dumps(options))) == repr(options)


def test_pickle_keeps_nested_values():
    options = surfit.SlamOptions(tracking="frame_to_frame")
    options.icp.error_model.kernel.width = 4.5
    loaded = pickle.loads(pickle.dumps(options))
    assert loaded.icp.error_model.kernel.width == 4.5 and loaded.tracking == "frame_to_frame"


def test_old_names_work_with_a_warning():
    options = surfit.FusionOptions()
    with pytest.warns(DeprecationWarning, match="max_inactive_frames"):
        options.max_dormant_frames = 7
    assert options.max_inactive_frames == 7
    with pytest.warns(DeprecationWarning, match="max_inactive_frames"):
        assert options.max_dormant_frames == 7
    with pytest.warns(DeprecationWarning, match="RectifyOptions"):
        assert surfit.PrepareOptions is surfit.RectifyOptions
    with pytest.raises(AttributeError):
        options.max_frames_dormant
