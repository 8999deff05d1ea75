"""`Record`: what is accepted, and what the errors say."""

from pathlib import Path

import attrs
import pytest

import mpmkit as mpm


def test_defaults_keep_position_velocity_and_stress():
    record = mpm.Record("run.vtkhdf")
    assert (record.every, record.fields, record.history) == (None, ("x", "v", "stress"), 10)
    assert (record.overwrite, record.compress, record.checkpoint) == (False, False, True)


def test_paths_and_times_are_taken_as_people_write_them():
    record = mpm.Record(Path("out") / "run.hdf", "50 ms", "v")
    assert record.path == str(Path("out") / "run.hdf")
    assert record.every == 0.05  # rounding: none, 50e-3 is the nearest double in both forms
    assert record.fields == ("v",)


@pytest.mark.parametrize("path", ["run.h5", "run", "", "run.vtkhd", "run.vtkhdf/"[:-1] + ".txt"])
def test_a_path_that_paraview_would_not_open_is_refused(path):
    with pytest.raises(mpm.ParameterError, match=r"Record.path must end in \.vtkhdf or \.hdf, got"):
        mpm.Record(path)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"every": 0.0}, "Record.every must be > 0, got 0"),
        ({"history": 0}, "Record.history must be >= 1, got 0"),
        ({"fields": ("v", "v")}, "each field once, got 'v' more than once"),
        ({"fields": ("stress.xx",)}, "names of particle fields"),
        ({"overwrite": 1}, "Record.overwrite must be true or false, got 1"),
    ],
)
def test_bad_values_are_named(arguments, message):
    with pytest.raises(mpm.ParameterError, match=message.replace("(", r"\(")):
        mpm.Record("run.vtkhdf", **arguments)


def test_a_record_cannot_be_changed():
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        mpm.Record("run.vtkhdf").every = 1.0
