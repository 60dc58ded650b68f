"""Every public class describes its instances, and a flight's samples have all that was measured."""

import importlib
import inspect

import numpy as np
import pytest
from matplotlib.figure import Figure

import uwsim
from uwsim.base.short_repr import described
from uwsim.missions import wait

PACKAGES = (
    "uwsim", "uwsim.batch", "uwsim.bridges", "uwsim.channels", "uwsim.exercises", "uwsim.flight",
    "uwsim.instruments.acoustics", "uwsim.evidence.identification", "uwsim.instruments.cameras",
    "uwsim.instruments.sonars.imaging", "uwsim.learning",
    "uwsim.link", "uwsim.live", "uwsim.mapping", "uwsim.missions", "uwsim.navigation.control",
    "uwsim.navigation.estimation", "uwsim.operator.station", "uwsim.recording", "uwsim.scoring",
)  # fmt: skip
WITHOUT = {"Site": "a function in the form of a class, which only servers call"}


def test_every_public_class_describes_its_instances() -> None:
    listed = [
        (module, name) for module in map(importlib.import_module, PACKAGES) for name in getattr(module, "__all__", ())
    ]
    classes = {name: each for module, name in listed if inspect.isclass(each := getattr(module, name))}
    silent = [
        name
        for name, each in classes.items()
        if each.__repr__ is object.__repr__ and not getattr(each, "_is_protocol", False)
    ]
    assert sorted(silent) == sorted(WITHOUT)


def test_only_what_is_public_is_listed() -> None:
    assert dir(uwsim) == sorted(uwsim.__all__)
    assert all(hasattr(uwsim, name) for name in uwsim.__all__)


def test_long_values_are_shown_by_their_shape() -> None:
    class Thing:
        level_db = np.zeros((3, 4), np.float32)
        centre_m = np.array([1.0, 2.5, -3.0])
        share = 1.0 / 3.0
        names = ("a",) * 9

    text = described(Thing(), ("level_db", "centre_m", "share", "names"))
    assert text == "Thing(level_db=float32 (3, 4), centre_m=[1, 2.5, -3], share=0.333333, names=9 items)"


def test_a_flight_s_samples_have_rates_fins_and_sensors() -> None:
    def mission(vehicle):
        vehicle.set_fins({"top": 0.2})
        vehicle.set_effort(surge=0.5)
        yield wait(2.0)

    vehicle = {"name": "auv", "model": "remus100", "start": {"position_m": [0, 0, -20]}}
    world = {"name": "sea", "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 4, "bed_depth_m": 60}}
    flown = uwsim.fly(mission, uwsim.Scenario.model_validate({**world, "vehicles": [vehicle]}))
    samples = flown.samples["auv"]
    np.testing.assert_allclose(np.gradient(samples["x_m"], 0.2)[1:-1], samples["surge_m_s"][1:-1], atol=0.06)
    assert samples["sensor depth"] == pytest.approx(samples["depth_m"], abs=0.1)
    assert {"fin top", "roll_rate_rad_s", "sensor imu angular_velocity_rad_s 2"} <= set(samples.names)
    assert samples.command_names == ("propeller",) and samples.commands.shape == (len(samples), 1)
    table = samples.pandas()
    assert table.index.name == "time_s" and list(table.columns) == list(samples.names[1:])
    assert table["thruster propeller"].to_numpy() == pytest.approx(samples.commands[:, 0])
    assert isinstance(flown.plot(), Figure)
