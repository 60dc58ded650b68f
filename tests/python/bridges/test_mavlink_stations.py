"""Requests of ground stations to a MAVLink vehicle: cameras, gimbal, rates, sticks, targets, and their handshakes.

The orders of requests are those of QGroundControl's InitialConnectStateMachine, APMFirmwarePlugin, CameraDiscovery and
GimbalController, and of Cockpit's MAVLinkVehicle and main vehicle store, as of November 2026, played by pymavlink.
"""

import math
import shutil
import socket
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from mavlink_station import CAMERA, Station
from uwsim import Simulator
from uwsim.bridges.actions import actions_of
from uwsim.bridges.mavlink import Endpoint, MavlinkVehicle
from uwsim.bridges.video import Target, VideoStream
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.scenario import load, load_vehicle

MANUAL, ALT_HOLD, GUIDED = 19, 2, 4
DONE, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    """A BlueROV2 with the lake vehicle's camera, which pans and tilts, and its lamps."""
    rov = load_vehicle("rov")
    model = load_vehicle("bluerov2_heavy").model_copy(update={"cameras": rov.cameras, "lamps": rov.lamps})
    with LiveSimulator(Simulator(load("lagoon").with_changes(vehicle_model=model), seed=3), speed=5.0) as live:
        yield live


@pytest.fixture(scope="module")
def vehicle(live: LiveSimulator) -> Iterator[MavlinkVehicle]:
    table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
    flight = next(action for action in actions_of(live.simulator, table) if action.name == "fly_path")
    with MavlinkVehicle(live, Endpoint.parse("udpin:127.0.0.1:0"), table.channels, action=flight) as vehicle:
        yield vehicle


def station_at(vehicle: MavlinkVehicle, system: int = 255) -> Station:
    station = Station(f"udpout:127.0.0.1:{vehicle.endpoint.port}", system)
    station.receive("HEARTBEAT")
    return station


@pytest.fixture(scope="module")
def only_station(vehicle: MavlinkVehicle) -> Iterator[Station]:
    station = station_at(vehicle)
    yield station
    station.close()


@pytest.fixture
def station(only_station: Station) -> Iterator[Station]:
    only_station.drain()
    yield only_station
    only_station.arm(False)


def pitch_yaw(station: Station, pitch: float, yaw: float, *rates: float, flags: int = 0) -> int:
    values = (pitch, yaw, *(rates or (math.nan, math.nan)), flags, 0, 1)
    return station.command(dialect.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, *values)


def gimbal_deg(station: Station) -> tuple[float, float]:
    q = station.receive("GIMBAL_DEVICE_ATTITUDE_STATUS").q
    yaw, pitch, roll = Rotation.from_quat(q, scalar_first=True).as_euler("ZYX", degrees=True)
    assert abs(roll) < 1e-3
    return float(pitch), float(yaw)


def test_cameras_are_found_by_their_heartbeats_and_describe_themselves(station: Station) -> None:
    camera = station.receive("HEARTBEAT", lambda beat: beat.get_srcComponent() == CAMERA)
    assert (camera.type, camera.autopilot) == (dialect.MAV_TYPE_CAMERA, dialect.MAV_AUTOPILOT_INVALID)
    information = station.request("CAMERA_INFORMATION", CAMERA)
    assert bytes(information.model_name).rstrip(b"\0") == b"front"
    assert (information.resolution_h, information.resolution_v) == (640, 360)
    assert information.gimbal_device_id == 1 and not information.flags  # no stream is sent here
    assert bytes(station.request("CAMERA_INFORMATION", CAMERA + 1).model_name).rstrip(b"\0") == b"down"
    assert station.request("VIDEO_STREAM_INFORMATION", CAMERA) == UNSUPPORTED
    for command, kind in ((521, "CAMERA_INFORMATION"), (522, "CAMERA_SETTINGS"), (525, "STORAGE_INFORMATION"),
                          (527, "CAMERA_CAPTURE_STATUS")):  # fmt: skip
        assert station.command(command, 1, component=CAMERA) == DONE
        station.receive(kind, limit_s=2)


@pytest.mark.skipif(shutil.which("ffmpeg") is None and find_spec("imageio_ffmpeg") is None, reason="needs ffmpeg")
def test_a_streamed_camera_announces_its_stream(live: LiveSimulator) -> None:
    with (
        VideoStream(live, "rov", Target.parse("5601"), "down") as video,
        MavlinkVehicle(live, Endpoint.parse("udpin:127.0.0.1:0"), (), action=None, video=video) as vehicle,
    ):
        station = station_at(vehicle)
        information = station.request("CAMERA_INFORMATION", CAMERA)
        assert bytes(information.model_name).rstrip(b"\0") == b"down"  # the streamed one is the first
        assert information.flags & dialect.CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM
        stream = station.request("VIDEO_STREAM_INFORMATION", CAMERA, 0)
        assert (stream.stream_id, stream.count, stream.type, stream.encoding) == (1, 1, 1, 1)
        assert (stream.uri, stream.flags, stream.resolution_h, stream.hfov) == ("5601", 1, 640, 84)
        assert station.command(dialect.MAV_CMD_VIDEO_STOP_STREAMING, 1, component=CAMERA) == DONE
        assert station.request("VIDEO_STREAM_STATUS", CAMERA, 1).flags == 0
        assert station.command(dialect.MAV_CMD_VIDEO_START_STREAMING, 1, component=CAMERA) == DONE
        assert station.command(dialect.MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION, 1, component=CAMERA) == DONE
        assert station.receive("VIDEO_STREAM_INFORMATION").flags == 1
        assert station.request("VIDEO_STREAM_INFORMATION", CAMERA, 2) == UNSUPPORTED
        station.close()


def test_a_request_to_all_components_is_answered_by_each_camera(station: Station) -> None:
    assert station.command(dialect.MAV_CMD_REQUEST_MESSAGE, 259, component=0) == DONE
    found = {station.receive("CAMERA_INFORMATION").get_srcComponent() for _ in range(2)}
    assert found == {CAMERA, CAMERA + 1}


def test_the_gimbal_turns_the_camera(live: LiveSimulator, station: Station) -> None:
    information = station.request("GIMBAL_MANAGER_INFORMATION")
    assert information.gimbal_device_id == 1
    assert math.degrees(information.pitch_min) == pytest.approx(-90)
    device = station.request("GIMBAL_DEVICE_INFORMATION")  # MAVSDK requests it
    assert (device.model_name, device.gimbal_device_id) == ("front", 1)
    assert pitch_yaw(station, 20, -30) == DONE
    until(lambda: gimbal_deg(station) == pytest.approx((20, -30), abs=0.1))
    pan, tilt = live.rov.cameras["front"].aim_rad
    assert (math.degrees(tilt), math.degrees(pan)) == pytest.approx((-20, 30), abs=0.1)  # down and to port are positive
    assert pitch_yaw(station, 120, 0) == FAILED
    assert "pitch = 120 deg" in station.receive("STATUSTEXT").text
    assert pitch_yaw(station, 0, 0, flags=dialect.GIMBAL_MANAGER_FLAGS_YAW_LOCK) == FAILED
    assert station.command(dialect.MAV_CMD_DO_MOUNT_CONTROL, -45, 0, 0, 0, 0, 0, 2) == DONE
    station.receive("NAMED_VALUE_FLOAT", lambda value: value.name == "CamTilt" and abs(value.value - 0.25) < 0.001)


def test_one_station_at_a_time_controls_the_gimbal(vehicle: MavlinkVehicle, station: Station) -> None:
    other = station_at(vehicle, 254)
    assert station.command(dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, -2, -2, -1, -1) == DONE
    assert station.receive("GIMBAL_MANAGER_STATUS").primary_control_sysid == 255
    assert pitch_yaw(other, 10, 0) == DENIED
    assert pitch_yaw(station, 10, 0) == DONE
    assert station.command(dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, -3, -3, -1, -1) == DONE
    assert pitch_yaw(other, 5, 0) == DONE
    other.close()


def test_rates_sticks_and_buttons_turn_the_camera_too(live: LiveSimulator, station: Station) -> None:
    assert pitch_yaw(station, 0, 0) == DONE
    until(lambda: abs(live.rov.cameras["front"].target_rad[1]) < 1e-6)
    assert pitch_yaw(station, math.nan, math.nan, 10, 0) == DONE
    until(lambda: live.rov.cameras["front"].target_rad[1] < -0.1)  # up, and it ends after a second
    assert pitch_yaw(station, math.nan, math.nan, 0, 0) == DONE
    tilt_down = 1 << 9
    station.mav.manual_control_send(1, 0, 0, 500, 0, tilt_down)
    lowest = live.rov.cameras["front"].target_rad[1]
    until(lambda: live.rov.cameras["front"].target_rad[1] > lowest + 0.1)
    station.mav.manual_control_send(1, 0, 0, 500, 0, 1 << 7)  # centre
    until(lambda: live.rov.cameras["front"].target_rad == (0.0, 0.0))


def until(condition: Callable[[], object], limit_s: float = 10.0) -> None:
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.01)


def test_buttons_and_channels_switch_the_lamps_and_modes(live: LiveSimulator, station: Station) -> None:
    lamps = live.rov.lamps.values()
    station.mav.manual_control_send(1, 0, 0, 500, 0, 1 << 14)
    until(lambda: all(lamp.on for lamp in lamps))
    station.receive("NAMED_VALUE_FLOAT", lambda value: value.name == "Lights1" and value.value == 1)
    rest = [65535] * 8
    station.mav.rc_channels_override_send(1, 1, *rest, 1100)
    until(lambda: not any(lamp.on for lamp in lamps))
    station.mav.manual_control_send(1, 0, 0, 500, 0, 1 << 6)  # arm
    station.receive("HEARTBEAT", lambda beat: beat.base_mode & 128)
    station.mav.manual_control_send(1, 0, 0, 500, 0, 1 << 2)  # depth hold
    station.receive("HEARTBEAT", lambda beat: beat.custom_mode == ALT_HOLD)
    station.mav.param_set_send(1, 1, b"BTN2_FUNCTION", 4, 6)  # now: disarm
    assert station.receive("PARAM_VALUE").param_value == 4
    station.mav.manual_control_send(1, 0, 0, 500, 0, 0)
    station.mav.manual_control_send(1, 0, 0, 500, 0, 1 << 2)
    station.receive("HEARTBEAT", lambda beat: beat.get_srcComponent() == 1 and not beat.base_mode & 128)
    station.mav.param_set_send(1, 1, b"BTN2_FUNCTION", 7, 6)


def test_channels_steer_and_hold_until_they_are_released(live: LiveSimulator, station: Station) -> None:
    station.arm()
    station.mode(MANUAL)
    keep, forward = [65535] * 4, 1700
    station.mav.rc_channels_override_send(1, 1, *keep, forward, *[65535] * 3)
    until(lambda: live.rov.effort[0] == pytest.approx(0.5))
    station.mav.rc_channels_override_send(1, 1, *keep, 65535, 1600, 65535, 65535)  # forward stays
    until(lambda: live.rov.effort[1] == pytest.approx(-0.25))
    assert live.rov.effort[0] == pytest.approx(0.5)
    station.mav.rc_channels_override_send(1, 1, *keep, 0, 0, 65535, 65535)
    until(lambda: not np.any(live.rov.effort))
    station.mav.rc_channels_override_send(1, 1, 5, *[65535] * 7)
    assert "chan1_raw = 5 us: must be in" in station.receive("STATUSTEXT", lambda text: "chan1" in text.text).text


def test_targets_are_global_local_or_offsets(live: LiveSimulator, station: Station) -> None:
    station.arm()
    assert station.mode(GUIDED) == DONE
    here = station.receive("LOCAL_POSITION_NED")
    at = station.receive("GLOBAL_POSITION_INT")
    mask = 0b110111111000
    north_e7 = round(2.0 / 111_000 * 1e7)
    station.mav.set_position_target_global_int_send(0, 1, 1, 6, mask, at.lat + north_e7, at.lon, -4.0, *[0.0] * 8)
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached", limit_s=30)
    now = station.receive("LOCAL_POSITION_NED")
    assert (now.x, now.y, now.z) == pytest.approx((here.x + 2, here.y, 4.0), abs=0.6)
    station.mav.set_position_target_local_ned_send(0, 1, 1, 7, mask, 0, 0, -1.0, *[0.0] * 8)  # Cockpit's way up
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached", limit_s=30)
    assert station.receive("LOCAL_POSITION_NED").z == pytest.approx(now.z - 1, abs=0.6)
    values = (-1, 1, 0, math.nan, at.lat, at.lon, -3.0)
    assert station.command(dialect.MAV_CMD_DO_REPOSITION, *values, as_int=True) == DONE
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached", limit_s=30)
    assert station.receive("LOCAL_POSITION_NED").x == pytest.approx(here.x, abs=0.6)
    for frame, words in ((8, "frame 8"), (1, "must be numbers")):
        station.mav.set_position_target_local_ned_send(0, 1, 1, frame, mask, math.nan, 0, 1, *[0.0] * 8)
        station.receive("STATUSTEXT", lambda text, words=words: words in text.text)


def interval(station: Station, number: int, interval_us: float) -> int:
    return station.command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, number, interval_us)


def counted(station: Station, kind: str, simulated_s: float) -> int:
    """Return the number of messages in a simulated time, by the clock of ATTITUDE."""
    began = station.receive("ATTITUDE").time_boot_ms
    heard = len(station.heard)
    station.receive("ATTITUDE", lambda attitude: attitude.time_boot_ms >= began + 1e3 * simulated_s)
    return sum(message.get_type() == kind for message in station.heard[heard:])


def test_messages_come_at_the_requested_rates(station: Station) -> None:
    ahrs, home = dialect.MAVLINK_MSG_ID_AHRS2, dialect.MAVLINK_MSG_ID_HOME_POSITION
    assert counted(station, "AHRS2", 2.0) == 0
    assert interval(station, ahrs, 62_500) == DONE  # Cockpit's 16 Hz
    assert 45 <= counted(station, "AHRS2", 3.0) <= 50
    assert 28 <= counted(station, "VFR_HUD", 3.0) <= 32
    assert interval(station, home, 1e6) == DONE
    assert 3 <= counted(station, "HOME_POSITION", 4.0) <= 5
    assert station.command(dialect.MAV_CMD_GET_MESSAGE_INTERVAL, ahrs) == DONE
    assert station.receive("MESSAGE_INTERVAL").interval_us == 62_500
    for number in (ahrs, home):
        assert interval(station, number, -1) == DONE
    assert interval(station, dialect.MAVLINK_MSG_ID_ATTITUDE, 1000) == DENIED  # 1 kHz
    assert interval(station, dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 1e6) == DENIED
    assert interval(station, ahrs, math.nan) == FAILED
    station.mav.request_data_stream_send(1, 1, 11, 2, 1)  # EXTRA2 at 2 Hz
    station.poll()
    assert 3 <= counted(station, "VFR_HUD", 2.0) <= 6
    assert interval(station, dialect.MAVLINK_MSG_ID_VFR_HUD, 0) == DONE
    assert 18 <= counted(station, "VFR_HUD", 2.0) <= 22


def test_each_station_gets_messages_numbered_without_gaps(vehicle: MavlinkVehicle, station: Station) -> None:
    """Also while the other one loads parameters, which only that one receives."""
    other = station_at(vehicle, 254)
    station.drain()
    other.drain()
    other.mav.param_request_list_send(1, 1)
    station.mav.param_request_list_send(1, 1)
    for each in (station, other):
        each.receive("PARAM_VALUE", lambda value: value.param_index == value.param_count - 1)
        numbers = [message.get_seq() for message in each.heard if message.get_srcComponent() == 1]
        assert len(numbers) > 200 and set(np.diff(numbers) % 256) == {1}
    other.close()


def test_qgroundcontrols_handshake(station: Station) -> None:
    """Rates; version; modes and component metadata, which are not here; parameters, missions; camera, gimbal."""
    station.mav.request_data_stream_send(1, 1, dialect.MAV_DATA_STREAM_EXTRA1, 10, 1)
    assert interval(station, dialect.MAVLINK_MSG_ID_HOME_POSITION, 1e6) == DONE
    assert interval(station, dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 1e6) == DENIED
    version = station.request("AUTOPILOT_VERSION")
    fence_or_rally = dialect.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE | dialect.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    assert version.flight_sw_version >> 24 == 4 and not version.capabilities & fence_or_rally
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
    assert set(acks) == {DONE, DENIED} and acks.count(DONE) == 11
    for kind in ("ATTITUDE", "AHRS2", "VFR_HUD", "GLOBAL_POSITION_INT", "SYS_STATUS", "BATTERY_STATUS", "RANGEFINDER",
                 "DISTANCE_SENSOR", "SYSTEM_TIME", "SCALED_PRESSURE2", "GIMBAL_DEVICE_ATTITUDE_STATUS"):  # fmt: skip
        station.receive(kind, lambda message: message.get_srcComponent() == 1)
    station.mav.timesync_send(0, 123456789)
    assert station.receive("TIMESYNC").ts1 == 123456789
    station.mav.system_time_send(1, 1)
    home = station.request("HOME_POSITION")
    station.mav.mission_count_send(1, 1, 2, 0)
    for seq in range(2):
        assert station.receive("MISSION_REQUEST_INT").seq == seq
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


def test_lost_messages_are_sent_again(vehicle: MavlinkVehicle, station: Station) -> None:
    """The vehicle requests items of an upload again, repeats its last answer, and sends parameters by index."""
    station.mav.mission_count_send(1, 1, 2)
    assert station.receive("MISSION_REQUEST_INT").seq == 0  # lost on its way
    assert station.receive("MISSION_REQUEST_INT", limit_s=3).seq == 0
    other = station_at(vehicle, 254)
    other.mav.mission_count_send(1, 1, 1)
    assert other.receive("MISSION_ACK").type == dialect.MAV_MISSION_DENIED
    other.close()
    for seq in range(2):
        station.mav.mission_item_send(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 33.81, -118.39, -1.0)  # in degrees
    station.receive("MISSION_ACK")
    station.mav.mission_item_send(1, 1, 1, 3, 16, 0, 1, 0, 0, 0, 0, 33.81, -118.39, -1.0)
    assert station.receive("MISSION_ACK").type == 0
    station.mav.mission_request_send(1, 1, 1)
    assert station.receive("MISSION_ITEM").x == pytest.approx(33.81, abs=1e-5)
    station.mav.mission_request_int_send(1, 1, 7)
    assert station.receive("MISSION_ACK").type == dialect.MAV_MISSION_INVALID_SEQUENCE
    station.mav.param_request_read_send(1, 1, b"", 3)
    assert station.receive("PARAM_VALUE").param_index == 3
    station.mav.mission_clear_all_send(1, 1)


def test_it_sends_to_a_listening_station(live: LiveSimulator) -> None:
    """`udpout`, which QGroundControl's UDP port 14550 receives; its answers come back."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
    with MavlinkVehicle(live, Endpoint("udpout", "127.0.0.1", port), table.channels, action=None):
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
    assert station.request("HOME_POSITION").latitude == round(33.810313e7)
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
    assert station.request("HOME_POSITION").latitude == round(33.810313e7)
    assert "a message failed" not in caplog.text
    for foe in foes:
        foe.close()
