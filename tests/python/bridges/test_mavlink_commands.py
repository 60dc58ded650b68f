"""Every parameter of every MAVLink command: a value without a meaning is denied, and changes nothing."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from mavlink_station import AUTOPILOT, CAMERA, DENIED, DONE, GUIDED, MANUAL, Station, station_at
from uwsim.bridges.actions.table import SPEED_M_S
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.bridges.mavlink.parameters import as_value
from uwsim.live import LiveSimulator

TERMINATE, ARM = dialect.MAV_CMD_DO_FLIGHTTERMINATION, dialect.MAV_CMD_COMPONENT_ARM_DISARM
NO_NUMBER = (math.inf, -math.inf, -1e30, 1e30)
NUMBER = (math.nan, math.inf, -math.inf)
WHOLE = (math.nan, *NO_NUMBER, 0.5)
SWITCH = (*WHOLE, 2, -1, 0.4999, 1.0000001)
READ: dict[int, tuple[tuple[float, ...], dict[int, tuple[float, ...]]]] = {
    176: ((1, MANUAL), {1: (*WHOLE, -1, 0, 254, 256), 2: WHOLE}),
    TERMINATE: ((1,), {1: SWITCH}),
    192: ((-1, 1, 0, math.nan, 338103130, -1183938670, -3), {1: (*NO_NUMBER, -0.5, 11), 2: WHOLE,
                                                            4: (math.inf, -math.inf), 7: (*NUMBER,)}),
    17: ((), {}),
    21: ((), {}),
    183: ((13, 1100), {1: (*WHOLE, 1, 14), 2: (*WHOLE, 799, 2201)}),
    207: ((1,), {1: SWITCH}),
    224: ((0,), {1: (*WHOLE, -1)}),
    300: ((), {1: (*WHOLE, 2), 2: (*WHOLE, 7)}),
    ARM: ((0,), {1: SWITCH}),
    520: ((1,), {1: (*WHOLE, 0, 2)}),
    410: ((), {}),
    510: ((30,), {1: WHOLE}),
    511: ((30, 100_000), {1: WHOLE, 2: (*NUMBER, -1e30, -2, -0.5)}),
    512: ((30,), {1: (math.nan, math.inf, -math.inf, 0.5), 2: (math.inf, -math.inf)}),
    521: ((1,), {1: SWITCH}),
    522: ((1,), {1: SWITCH}),
    525: ((0, 1), {1: (*WHOLE, 2), 2: SWITCH}),
    527: ((1,), {1: SWITCH}),
    2504: ((1,), {1: (*WHOLE, 2, -1)}),
    2505: ((1,), {1: (*WHOLE, 2, -1)}),
    2502: ((1,), {1: (*WHOLE, 2, -1)}),
    2503: ((1,), {1: (*WHOLE, 2, -1)}),
    204: ((2,), {1: (*WHOLE, 7, -1), 2: SWITCH, 3: SWITCH, 4: SWITCH}),
    205: ((-10, 0, 0, 0, 0, 0, 2), {1: NUMBER, 2: NUMBER, 3: NUMBER, 7: (*WHOLE, 7, -1)}),
    1000: ((10, 0, math.nan, math.nan, 0, 0, 0), {1: (math.inf, -math.inf), 2: (math.inf, -math.inf),
                                                  3: (math.inf, -math.inf), 4: (math.inf, -math.inf), 5: WHOLE,
                                                  7: (*WHOLE, 2, -1)}),
    1001: ((-1, -1, -1, -1), {1: (*WHOLE, -4, 256), 2: (*WHOLE, -4, 256), 7: (*WHOLE, 2)}),
}  # fmt: skip
"""A valid call of each command, and the values that each parameter with a meaning must not have."""


@pytest.fixture(scope="module")
def station(vehicle: MavlinkVehicle) -> Iterator[Station]:
    station = station_at(vehicle)
    yield station
    station.close()


def state(live: LiveSimulator, vehicle: MavlinkVehicle) -> Any:
    flight, rov = vehicle._flight, live.rov
    streams, gimbal = vehicle._streams, vehicle._gimbal
    return (rov.all_stopped, flight.is_armed, flight._flies, flight._target, rov.cameras["front"].target_rad,
            dict(streams._rates_hz), gimbal._owner, gimbal._rates_rad_s)  # fmt: skip


def commands_of(vehicle: MavlinkVehicle) -> set[tuple[int, int]]:
    """Return the components and their commands."""
    own = {(AUTOPILOT, command) for command in vehicle._commands._obeys}
    return own | {(CAMERA, command) for camera in vehicle._cameras for command in camera.commands._obeys}


def test_every_command_is_in_this_files_table(vehicle: MavlinkVehicle) -> None:
    assert {command for _, command in commands_of(vehicle)} <= READ.keys()


@pytest.mark.parametrize("is_stopped", [True, False], ids=["stopped", "armed"])
def test_a_bad_value_in_any_parameter_is_denied(
    live: LiveSimulator, vehicle: MavlinkVehicle, station: Station, is_stopped: bool
) -> None:
    """While all stop is set, and while the vehicle is armed, so that a wrong "on" and a wrong "off" would show."""
    assert station.command(TERMINATE, float(is_stopped)) == DONE
    if not is_stopped:
        assert station.arm() == DONE and station.mode(GUIDED) == DONE
    before, wrong = state(live, vehicle), []
    for component, command in sorted(commands_of(vehicle)):
        good, bad = READ[command]
        for index, values in bad.items():
            for value in values:
                given = [*good, *[0.0] * (7 - len(good))]
                given[index - 1] = value
                station.heard.clear()
                result = station.command(command, *given, component=component, as_int=command == 192)
                if result != DENIED or state(live, vehicle) != before:
                    wrong.append((command, index, value, result))
                    station.command(TERMINATE, 1.0)
                    before = state(live, vehicle)
    assert not wrong
    station.command(TERMINATE, 0.0)


def test_the_table_states_valid_calls(vehicle: MavlinkVehicle, station: Station) -> None:
    assert station.arm() == DONE
    for component, command in sorted(commands_of(vehicle) - {(AUTOPILOT, 300)}, key=lambda key: key[1] == ARM):
        if command in (2504, 2505, TERMINATE):  # no stream is sent here
            continue
        good = [*READ[command][0], *[0.0] * (7 - len(READ[command][0]))]
        number = 259 if (component, command) == (CAMERA, 512) else good[0]
        result = station.command(command, number, *good[1:], component=component, as_int=command == 192)
        assert result == DONE, (component, command, result)


def test_a_reposition_flies_at_the_speed_that_it_states(vehicle: MavlinkVehicle, station: Station) -> None:
    assert station.arm() == DONE
    here = station.receive("GLOBAL_POSITION_INT")
    target = (here.lat + 200, here.lon, -3.0)
    for speed, flown in ((0.2, pytest.approx(0.2)), (-1, SPEED_M_S)):
        assert station.command(192, speed, 1, 0, math.nan, *target, as_int=True) == DONE
        assert vehicle._flight._target.speed_m_s == flown
    assert station.command(192, -1, 2, 0, 1.0, *target, as_int=True) == DENIED  # a relative yaw
    station.arm(False)


@pytest.mark.parametrize(
    ("present", "number"), [(True, math.nan), (False, -1e30), (True, 0.5), (3, 2.5), (3, math.inf), (0.5, math.nan)]
)
def test_a_parameter_keeps_its_type(present: Any, number: float) -> None:
    with pytest.raises(ValueError, match="must be"):
        as_value(number, present)
    assert as_value(1.0, present) == 1 and isinstance(as_value(1.0, present), type(present))


@pytest.mark.parametrize("q", [(0.0,) * 4, (math.nan, 0.0, 0.0, 1.0), (math.inf, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0)])
def test_an_attitude_without_length_one_turns_nothing(
    live: LiveSimulator, station: Station, q: tuple[float, ...]
) -> None:
    aim = live.rov.cameras["front"].target_rad
    station.mav.gimbal_manager_set_attitude_send(1, 1, 0, 1, q, math.nan, math.nan, math.nan)
    station.receive("STATUSTEXT", lambda text: "gimbal: q" in text.text)
    assert live.rov.cameras["front"].target_rad == aim
