"""Parameters that a firmware has kept, where the simulation needs others."""

import logging
from typing import Any

import pytest

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from uwsim.bridges.firmware.kept_parameters import REBOOT, ROUNDS, SETTLED, KeptParameters

NEEDED = {"FRAME_CONFIG": 2.0, "BARO_SPEC_GRAV": 1.0227599143981934, "VISO_TYPE": 1.0, "NOT_THERE": 3.0}


def heard_by(kept: dict[str, float], seconds: int = ROUNDS + SETTLED + 3) -> list[Any]:
    """Return the messages to a firmware that has kept these values, and answers as ArduSub does."""
    heard: list[Any] = []
    ours = KeptParameters(NEEDED, dialect.MAVLink(None), 1, heard.append)
    for _ in range(seconds):
        before = len(heard)
        ours.act()
        for message in heard[before:]:
            name = getattr(message, "param_id", "")
            if name in kept:
                kept[name] = getattr(message, "param_value", kept[name])
                ours.note(dialect.MAVLink_param_value_message(name.encode(), kept[name], 9, len(kept), 0))
    assert ours.is_done
    return heard


def test_what_differs_is_set_and_the_firmware_starts_again(caplog: pytest.LogCaptureFixture) -> None:
    """Others are left alone; a parameter that this version does not have is no obstacle."""
    caplog.set_level(logging.WARNING)
    kept = {"FRAME_CONFIG": 1.0, "BARO_SPEC_GRAV": 1.02276, "VISO_TYPE": 0.0, "SURFACE_DEPTH": -33.0}
    heard = heard_by(kept)
    assert [each.param_id for each in heard if each.get_type() == "PARAM_SET"] == ["FRAME_CONFIG", "VISO_TYPE"]
    assert kept == {"FRAME_CONFIG": 2.0, "BARO_SPEC_GRAV": 1.02276, "VISO_TYPE": 1.0, "SURFACE_DEPTH": -33.0}
    commands = [each.command for each in heard if each.get_type() == "COMMAND_LONG"]
    assert commands == [REBOOT] and heard[-1].get_type() == "COMMAND_LONG"
    assert "starts again with FRAME_CONFIG = 2, VISO_TYPE = 1" in caplog.text


def test_a_firmware_with_the_right_values_is_left_alone() -> None:
    assert {each.get_type() for each in heard_by(dict(NEEDED))} == {"PARAM_REQUEST_READ"}
