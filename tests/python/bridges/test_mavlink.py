"""A vehicle as a MAVLink system, with pymavlink's client as the ground station."""

import socket
import time
from collections.abc import Iterator

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.bridges.actions import actions_of
from uwsim.bridges.mavlink.earth import euler_rad, ned_from_frd
from uwsim.bridges.mavlink.endpoint import FORM
from uwsim.bridges.mavlink.modes import HOLDS_OF, mode_of
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.live.command_log import replay
from uwsim.mapping.files.georeference import Home
from uwsim.simulator.helm import Source
from waiting import until

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from mavlink_station import ALT_HOLD, DENIED, DONE, FAILED, MANUAL, Station
from uwsim.bridges.mavlink import MavlinkVehicle


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator(Simulator("lagoon", seed=3), speed=20.0) as live:
        yield live


@pytest.fixture(scope="module")
def vehicle(live: LiveSimulator) -> Iterator[MavlinkVehicle]:
    table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
    flight = next(action for action in actions_of(live.simulator, table) if action.name == "fly_path")
    endpoint = FORM.parse("tcp:127.0.0.1:0")
    with MavlinkVehicle(live, endpoint, table.channels, table.services, action=flight) as vehicle:
        yield vehicle


@pytest.fixture
def station(vehicle: MavlinkVehicle) -> Iterator[Station]:
    station = Station(f"tcp:{vehicle.endpoint.host}:{vehicle.endpoint.port}")
    yield station
    station.arm(False)
    station.close()


def test_it_reports_itself_as_an_ardusub(station: Station) -> None:
    heartbeat = station.receive("HEARTBEAT")
    assert (heartbeat.type, heartbeat.autopilot, heartbeat.custom_mode) == (12, 3, MANUAL)
    for kind in ("ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "SCALED_PRESSURE2", "VFR_HUD", "SYS_STATUS",
                 "BATTERY_STATUS", "RANGEFINDER", "NAMED_VALUE_FLOAT"):  # fmt: skip
        station.receive(kind)
    assert station.command(dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION) == 0
    assert station.receive("AUTOPILOT_VERSION").capabilities & dialect.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    assert station.command(dialect.MAV_CMD_NAV_TAKEOFF) == dialect.MAV_RESULT_UNSUPPORTED


def test_sticks_move_it_once_it_is_armed_and_its_modes_are_holds(live: LiveSimulator, station: Station) -> None:
    sticks = station.mav.manual_control_send
    sticks(1, 1000, 0, 500, 0, 0)
    time.sleep(0.2)
    assert not np.any(live.rov.effort)
    assert station.arm() == 0
    assert live.rov.released
    station.receive("HEARTBEAT", lambda message: message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)
    assert station.mode(MANUAL) == 0
    began = station.receive("LOCAL_POSITION_NED")

    def has_moved() -> bool:
        sticks(1, 1000, 0, 500, 0, 0)
        there = station.receive("LOCAL_POSITION_NED")
        return bool(np.hypot(there.x - began.x, there.y - began.y) > 0.5)

    until(has_moved)
    assert station.mode(ALT_HOLD) == 0
    station.receive("HEARTBEAT", lambda message: message.custom_mode == ALT_HOLD)
    assert {name for name, target in live.rov.holds.targets.items() if target} == set(HOLDS_OF[ALT_HOLD])
    assert station.mode(7) == dialect.MAV_RESULT_FAILED
    assert "mode 7: must be one of" in station.receive("STATUSTEXT").text
    custom = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    for base, mode, result in ((custom, MANUAL, DONE), (custom, 7, FAILED), (0, ALT_HOLD, DENIED)):
        station.mav.set_mode_send(1, base, mode)  # which ArduPilot acknowledges, too
        ack = station.receive("COMMAND_ACK", lambda ack: ack.command == dialect.MAVLINK_MSG_ID_SET_MODE)
        assert ack.result == result


def test_an_item_that_cannot_be_flown_is_refused_with_the_reason(station: Station) -> None:
    station.mav.mission_count_send(1, 1, 2)
    for seq, altitude in ((0, 0.0), (1, 5.0)):
        station.receive("MISSION_REQUEST", lambda request, seq=seq: request.seq == seq)
        station.mav.mission_item_int_send(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 0, 0, altitude)
    assert station.receive("MISSION_ACK").type == dialect.MAV_MISSION_INVALID_PARAM7
    assert "mission item 1: altitude 5 m" in station.receive("STATUSTEXT").text


def test_parameters_are_listed_read_and_set(live: LiveSimulator, station: Station) -> None:
    mav = station.mav
    mav.param_request_list_send(1, 1)
    first = station.receive("PARAM_VALUE")
    names = {first.param_id}
    while len(names) < first.param_count:
        names.add(station.receive("PARAM_VALUE").param_id)
    assert all(len(name) <= 16 for name in names)
    mav.param_set_send(1, 1, b"MASS_KG", 14.0, 9)
    assert station.receive("PARAM_VALUE", lambda value: value.param_id == "MASS_KG").param_value == 14.0
    assert live.simulator.parameters["rov.mass_kg"] == 14.0
    mav.param_set_send(1, 1, b"MASS_KG", -1.0, 9)
    assert station.receive("PARAM_VALUE", lambda value: value.param_id == "MASS_KG").param_value == 14.0
    assert "mass_kg" in station.receive("STATUSTEXT").text
    mav.param_set_send(1, 1, b"WPNAV_RADIUS", 50.0, 9)
    assert station.receive("PARAM_VALUE", lambda value: value.param_id == "WPNAV_RADIUS").param_value == 50.0
    assert live.simulator.parameters["rov.xy_goal_tolerance"] == 0.5
    mav.param_set_send(1, 1, b"WPNAV_RADIUS", 10.0, 9)
    mav.param_set_send(1, 1, b"MASS_KG", 13.5, 9)
    station.receive("PARAM_VALUE", lambda value: value.param_value == 13.5)


def test_an_unknown_parameter_is_answered(station: Station) -> None:
    ask, unknown = station.mav, dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
    for send, name, index in (
        (lambda: ask.param_request_read_send(1, 1, b"NO_SUCH", -1), "NO_SUCH", -1),
        (lambda: ask.param_request_read_send(1, 1, b"", 30_000), "", 30_000),
        (lambda: ask.param_request_read_send(1, 1, b"", -2), "", -2),
        (lambda: ask.param_set_send(1, 1, b"SIXTEEN_LETTERS_", 1.0, 9), "SIXTEEN_LETTERS_", -1),
    ):
        send()
        error = station.receive("PARAM_ERROR")
        assert (error.target_system, error.param_id, error.param_index, error.error) == (255, name, index, unknown)


@pytest.mark.parametrize("length", [49, 50, 51, 100, 300])
def test_a_long_text_ends_where_stations_expect_it(vehicle: MavlinkVehicle, station: Station, length: int) -> None:
    """MAVLink: any null character is taken to mean this was the last chunk; the number 0 that there is only one."""
    station.receive("HEARTBEAT")  # which it gets once it is known
    vehicle.send_text("depth = " + "é" * (length - 6))
    parts = [station.receive("STATUSTEXT", lambda text: text.text.startswith("depth ?"))]
    while parts[0].id and len(parts[-1].text) == 50:
        parts.append(station.receive("STATUSTEXT", lambda text: text.id == parts[0].id))
    assert [part.chunk_seq for part in parts] == [*range(len(parts))]
    whole = "".join(part.text for part in parts)
    assert whole == ("depth " + "?" * (length - 6) if length <= 200 else "depth " + "?" * 191 + "...")


def test_the_stations_pilot_comes_first(vehicle: MavlinkVehicle, station: Station) -> None:
    assert vehicle._action is not None
    helm = vehicle._action.steering.helm
    lease = helm.take(Source.PILOT, "Ada")
    try:
        assert station.arm() == 0
        assert station.mode(ALT_HOLD) == dialect.MAV_RESULT_FAILED
        assert "Ada has the controls" in station.receive("STATUSTEXT", lambda text: "Ada" in text.text).text
        assert station.command(dialect.MAV_CMD_DO_FLIGHTTERMINATION, 1) == 0  # anybody may stop it
    finally:
        lease.end()
    assert vehicle._live.rov.all_stopped
    assert station.command(dialect.MAV_CMD_DO_FLIGHTTERMINATION, 0) == 0
    assert not vehicle._live.rov.all_stopped


def test_a_browsers_request_is_disconnected(vehicle: MavlinkVehicle) -> None:
    with socket.create_connection((vehicle.endpoint.host, vehicle.endpoint.port), 5) as page:
        page.sendall(b"POST / HTTP/1.1\r\n\r\n" + dialect.MAVLink(None).heartbeat_encode(6, 8, 0, 0, 0).pack(
            dialect.MAVLink(None)))  # fmt: skip
        page.settimeout(5)
        data = b"?"
        while data:
            data = page.recv(4096)


def test_what_it_did_replays_to_the_byte(live: LiveSimulator, vehicle: MavlinkVehicle) -> None:
    live.pause()
    state, tick = live.read(lambda sim: sim.save_state()).result(), live.tick
    live.resume()
    assert replay(Simulator("lagoon", seed=3), live.log, tick).save_state() == state


@pytest.mark.parametrize("mode", HOLDS_OF)
def test_each_mode_has_holds_of_its_own(mode: int) -> None:
    assert mode_of(HOLDS_OF[mode]) == mode


def test_places_and_angles_are_those_of_mavlink() -> None:
    """Against pymavlink's own geodesy, on a sphere: within 0.4 % over 1 km."""
    from pymavlink.mavextra import gps_offset
    from scipy.spatial.transform import Rotation

    home = Home(56.0, 10.0)
    point = np.array([600.0, 800.0, -5.0])
    lat, lon = home.degrees(point)
    np.testing.assert_allclose(home.world_m(lat, lon, -5.0), point, atol=1e-6)
    np.testing.assert_allclose((lat, lon), gps_offset(56.0, 10.0, 600.0, 800.0), rtol=0, atol=0.004 * 0.01)
    world_from_body = np.eye(4)
    # right side down by 0.1, nose up by 0.2, heading 0.3 to the right of north
    turn = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1])
    swap = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
    world_from_body[:3, :3] = swap.T @ turn.as_matrix() @ np.diag([1, -1, -1])
    assert euler_rad(world_from_body) == pytest.approx((0.1, 0.2, 0.3))
    q = ned_from_frd(Rotation.from_matrix(world_from_body[:3, :3]).as_quat())
    assert (Rotation.from_quat(q, scalar_first=True) * turn.inv()).magnitude() < 1e-12
