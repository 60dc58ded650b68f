"""The first requests of ground stations to a MAVLink vehicle, lost messages, several stations, and hostile ones.

The orders of requests are those of QGroundControl's InitialConnectStateMachine, APMFirmwarePlugin, CameraDiscovery and
GimbalController, and of Cockpit's MAVLinkVehicle and main vehicle store, as of November 2026, played by pymavlink.
"""

import math
import socket

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from listening_sockets import free_port
from mavlink_station import CAMERA, DENIED, DONE, UNSUPPORTED, Station, interval
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator


def test_each_station_gets_messages_numbered_without_gaps(other: Station, station: Station) -> None:
    """Also while the other one loads parameters, which only that one receives."""
    station.drain()
    other.drain()
    other.mav.param_request_list_send(1, 1)
    station.mav.param_request_list_send(1, 1)
    for each in (station, other):
        each.receive("PARAM_VALUE", lambda value: value.param_index == value.param_count - 1)
        numbers = [message.get_seq() for message in each.heard if message.get_srcComponent() == 1]
        assert len(numbers) > 200 and set(np.diff(numbers) % 256) == {1}


def test_qgroundcontrols_handshake(station: Station) -> None:
    """Rates; version; modes and component metadata, which are not here; parameters, missions; camera, gimbal."""
    station.mav.request_data_stream_send(1, 1, dialect.MAV_DATA_STREAM_EXTRA1, 10, 1)
    assert interval(station, dialect.MAVLINK_MSG_ID_HOME_POSITION, 1e6) == DONE
    assert interval(station, dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 1e6) == DONE
    version = station.request("AUTOPILOT_VERSION")
    fence_or_rally = dialect.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE | dialect.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    assert version.flight_sw_version >> 24 == 4 and version.capabilities & fence_or_rally == fence_or_rally
    assert version.capabilities & dialect.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    for number in (435, 397, 395):  # AVAILABLE_MODES, COMPONENT_METADATA, COMPONENT_INFORMATION: it goes on without
        assert station.command(dialect.MAV_CMD_REQUEST_MESSAGE, number) == UNSUPPORTED
    station.mav.param_request_list_send(1, 0)
    first = station.receive("PARAM_VALUE")
    found = {first.param_index}
    while len(found) < first.param_count:
        found.add(station.receive("PARAM_VALUE").param_index)
    assert found == set(range(first.param_count))
    for kind in (0, 1, 2):  # if AUTOPILOT_VERSION was lost, it assumes a fence and rally points
        station.mav.mission_request_list_send(1, 1, kind)
        count = station.receive("MISSION_COUNT")
        assert (count.count, count.mission_type) == (0, kind)
    station.receive("HEARTBEAT", lambda beat: beat.get_srcComponent() == CAMERA)
    assert station.request("CAMERA_INFORMATION", CAMERA).get_type() == "CAMERA_INFORMATION"
    assert station.command(dialect.MAV_CMD_REQUEST_CAMERA_SETTINGS, 1, component=CAMERA) == DONE
    assert station.command(dialect.MAV_CMD_REQUEST_STORAGE_INFORMATION, 0, 1, component=CAMERA) == DONE
    assert station.request("GIMBAL_MANAGER_INFORMATION", CAMERA) == UNSUPPORTED  # each heartbeat is a potential manager
    assert station.request("GIMBAL_MANAGER_INFORMATION").gimbal_device_id == 1
    assert interval(station, dialect.MAVLINK_MSG_ID_GIMBAL_MANAGER_STATUS, 0) == DONE
    station.receive("GIMBAL_MANAGER_STATUS")
    assert interval(station, dialect.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS, 0) == DONE
    station.receive("GIMBAL_DEVICE_ATTITUDE_STATUS")


COCKPIT_HZ = {27: 2, 116: 2, 129: 2, 29: 2, 137: 2, 143: 2, 1: 2, 125: 2, 152: 2, 24: 2, 127: 2, 124: 2, 128: 2, 62: 2,
              162: 2, 33: 3, 36: 2, 65: 2, 35: 2, 30: 16, 164: 10, 178: 16, 194: 10, 74: 16, 163: 16, 2: 3, 173: 3,
              132: 3, 147: 3, 285: 16, 100: 3, 192: 3, 191: 3, 193: 3, 241: 3, 22: 2}  # fmt: skip
"""Cockpit's defaultMessageFrequency by message number."""


def test_cockpits_handshake(station: Station) -> None:
    """All intervals at once, of which denied ones are only logged; the delay; home, the mission; parameters."""
    for number, rate_hz in COCKPIT_HZ.items():
        station.mav.command_long_send(
            1, 1, dialect.MAV_CMD_SET_MESSAGE_INTERVAL, 0, number, round(1e6 / rate_hz), *[0.0] * 5
        )
    acks = [station.receive("COMMAND_ACK").result for _ in COCKPIT_HZ]
    assert set(acks) == {DONE, DENIED} and acks.count(DONE) == 16
    for kind in ("ATTITUDE", "AHRS2", "VFR_HUD", "GLOBAL_POSITION_INT", "SYS_STATUS", "BATTERY_STATUS", "RANGEFINDER",
                 "DISTANCE_SENSOR", "SYSTEM_TIME", "SCALED_PRESSURE2", "GIMBAL_DEVICE_ATTITUDE_STATUS"):  # fmt: skip
        station.receive(kind, lambda message: message.get_srcComponent() == 1)
    station.mav.timesync_send(0, 123456789)
    assert station.receive("TIMESYNC").ts1 == 123456789
    station.mav.system_time_send(1, 1)
    home = station.request("HOME_POSITION")
    station.mav.mission_count_send(1, 1, 2, 0)
    for seq in range(2):
        station.receive("MISSION_REQUEST", lambda asked, seq=seq: asked.seq == seq)  # which may come again
        station.mav.mission_item_int_send(
            1, 1, seq, 6, 16, 0, 1, 0, 0, 0, 0, home.latitude, home.longitude, -2.0 * seq, 0
        )
    assert station.receive("MISSION_ACK").type == 0
    station.mav.mission_request_list_send(1, 1, 0)
    assert station.receive("MISSION_COUNT").count == 2
    for seq in range(2):
        station.mav.mission_request_int_send(1, 0, seq, 0)
        assert station.receive("MISSION_ITEM_INT").z == -2.0 * seq
    station.mav.mission_ack_send(1, 0, 0, 0)
    station.mav.mission_clear_all_send(1, 1, 0)
    assert station.receive("MISSION_ACK").type == 0
    station.mav.param_request_list_send(1, 0)
    station.receive("PARAM_VALUE", lambda value: value.param_id == "BTN0_FUNCTION")  # without them it sends no buttons


def test_lost_messages_are_sent_again(vehicle: MavlinkVehicle, station: Station, other: Station) -> None:
    """The vehicle requests items of an upload again, repeats its last answer, and sends parameters by index."""
    station.mav.mission_count_send(1, 1, 2)
    assert station.receive("MISSION_REQUEST").seq == 0  # lost on its way
    assert station.receive("MISSION_REQUEST").seq == 0
    other.mav.mission_count_send(1, 1, 1)
    assert other.receive("MISSION_ACK").type == dialect.MAV_MISSION_DENIED
    for seq in range(2):
        station.mav.mission_item_send(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 33.8103, -118.3938, -1.0)  # in degrees
    station.receive("MISSION_ACK")
    station.mav.mission_item_send(1, 1, 1, 3, 16, 0, 1, 0, 0, 0, 0, 33.8103, -118.3938, -1.0)
    assert station.receive("MISSION_ACK").type == 0
    station.mav.mission_request_send(1, 1, 1)
    assert station.receive("MISSION_ITEM").x == pytest.approx(33.8103, abs=1e-5)
    station.mav.mission_request_int_send(1, 1, 7)
    assert station.receive("MISSION_ACK").type == dialect.MAV_MISSION_INVALID_SEQUENCE
    station.mav.param_request_read_send(1, 1, b"", 3)
    assert station.receive("PARAM_VALUE").param_index == 3
    station.mav.mission_clear_all_send(1, 1)


def test_it_sends_to_a_listening_station(live: LiveSimulator) -> None:
    """`udpout`, which QGroundControl's UDP port 14550 receives; its answers come back."""
    port = free_port(socket.SOCK_DGRAM)
    table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
    with MavlinkVehicle(live, Endpoint("127.0.0.1", port, "udpout"), table.channels, action=None):
        listening = Station(f"udpin:127.0.0.1:{port}")
        listening.receive("HEARTBEAT")
        assert listening.request("AUTOPILOT_VERSION").flight_sw_version
        listening.close()


BAD_MESSAGES = [
    ("command_long", (1, 1, 400, 0, *[math.nan] * 7)), ("command_long", (1, 1, 176, 0, *[math.inf] * 7)),
    ("command_int", (1, 1, 3, 192, 0, 0, *[math.nan] * 4, 2**31 - 1, -(2**31), math.nan)),
    ("command_long", (1, 1, 512, 0, -1e30, *[0.0] * 6)), ("command_long", (1, 1, 511, 0, 30, -1e30, *[0.0] * 5)),
    ("command_long", (1, 1, 510, 0, 1e9, *[0.0] * 6)), ("command_long", (1, 1, 1000, 0, *[math.inf] * 7)),
    ("command_long", (1, 1, 1000, 0, *[math.nan] * 7)),
    ("mission_item", (1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, 1e30, 0, 0)), ("command_ack", (1, 0, 0, 0, 1, 0)),
    ("command_long", (1, 1, 1001, 0, *[1e6] * 7)),
    ("command_long", (1, 1, 205, 0, *[math.nan] * 6, 2)), ("command_long", (1, 100, 2504, 0, *[math.nan] * 7)),
    ("manual_control", (1, 32767, -32768, 32767, -32768, 0xFFFF)), ("rc_channels_override", (1, 1, *[65533] * 8)),
    ("param_set", (1, 1, b"MASS_KG", math.nan, 9)), ("param_set", (1, 1, b"BTN0_FUNCTION", -7, 6)),
    ("param_set", (1, 1, b"NO_SUCH", 1, 9)), ("param_request_read", (1, 1, b"", 32767)),
    ("mission_count", (1, 1, 65535)), ("mission_item", (1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, math.nan, math.inf, 0)),
    ("set_mode", (1, 1, 2**32 - 1)), ("request_data_stream", (1, 1, 255, 65535, 1)),
    ("gimbal_manager_set_attitude", (1, 1, 0, 1, [0.0] * 4, math.nan, math.inf, math.nan)),
    ("gimbal_manager_set_pitchyaw", (1, 1, 2**32 - 1, 1, math.inf, math.nan, math.inf, math.inf)),
]  # fmt: skip


def test_messages_with_bad_values_leave_it_as_it_is(
    live: LiveSimulator, station: Station, caplog: pytest.LogCaptureFixture
) -> None:
    aim = live.rov.cameras["front"].target_rad
    for name, values in BAD_MESSAGES:
        getattr(station.mav, f"{name}_send")(*values)
    station.drain()
    assert station.request("GPS_GLOBAL_ORIGIN").latitude == round(33.810313e7)
    assert "a message failed" not in caplog.text and "a sink failed" not in caplog.text, caplog.text
    assert live.rov.cameras["front"].target_rad == aim
    assert live.simulator.parameters["rov.mass_kg"] == 13.5


def test_noise_on_the_port_is_ignored(
    vehicle: MavlinkVehicle, station: Station, caplog: pytest.LogCaptureFixture
) -> None:
    """Random bytes, cut messages, foreign packets; from more addresses than are served."""
    random = np.random.default_rng(5)
    whole = bytes(dialect.MAVLink(None).heartbeat_encode(6, 8, 0, 0, 0).pack(dialect.MAVLink(None)))
    address = ("127.0.0.1", vehicle.endpoint.port)
    foes = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(12)]
    for foe in foes:
        for _ in range(20):
            foe.sendto(random.bytes(int(random.integers(1, 300))), address)
            foe.sendto(b"\xfd" + random.bytes(int(random.integers(0, 300))), address)
            foe.sendto(whole[: int(random.integers(1, len(whole)))], address)
            foe.sendto(b"GET / HTTP/1.1\r\n\r\n", address)
    assert station.request("GPS_GLOBAL_ORIGIN").latitude == round(33.810313e7)
    assert "a message failed" not in caplog.text
    for foe in foes:
        foe.close()
