"""Every example runs and prints output; those that fly for long do so in smaller areas, with smaller pictures."""

import importlib
import pkgutil

import pytest

import uwsim.examples
from uwsim.examples import (
    m04_into_the_unknown,
    m09_two_vehicles,
    m10_digital_twin,
    m13_boat_and_rov,
    m14_glider,
    m15_launch_and_recovery,
)
from uwsim.missions.planners import pipeline

LESS = [
    (m04_into_the_unknown.mission, "__defaults__", (8.0,)),
    (pipeline, "LOOK_PIXELS", 80),
    (
        m09_two_vehicles,
        "HALVES_M",
        {
            "rov": [[-8.0, 2.0], [4.0, 2.0], [4.0, 10.0], [-8.0, 10.0]],
            "scout": [[-8.0, -10.0], [4.0, -10.0], [4.0, -2.0], [-8.0, -2.0]],
        },
    ),
    (m10_digital_twin, "AREA_M", [[-9, -18], [0, -18], [0, -10], [-9, -10]]),
    (m13_boat_and_rov, "ROUND_M", m13_boat_and_rov.ROUND_M[:2]),
    (m14_glider, "DIVES", 1),
    (m15_launch_and_recovery, "SITE_M", m15_launch_and_recovery.SITE_M[:2]),
]


@pytest.mark.parametrize("name", [module.name for module in pkgutil.iter_modules(uwsim.examples.__path__)])
def test_the_example_runs(name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for owner, setting, value in LESS:
        monkeypatch.setattr(owner, setting, value)
    importlib.import_module(f"uwsim.examples.{name}").main()
    assert capsys.readouterr().out.strip()
