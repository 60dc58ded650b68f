"""Cameras, gimbal, sticks, targets and rates of a MAVLink vehicle, with pymavlink as the ground station."""

import math
import shutil
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from mavlink_station import (
    ALT_HOLD,
    CAMERA,
    DENIED,
    DONE,
    FAILED,
    GUIDED,
    MANUAL,
    UNSUPPORTED,
    Station,
    interval,
    station_at,
)
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.bridges.mavlink.refusals import Refusals
from uwsim.bridges.video.video import VideoStream
from uwsim.live import LiveSimulator
from uwsim.simulator.helm import Source
from waiting import until


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
        station.receive(kind)


@pytest.mark.skipif(shutil.which("ffmpeg") is None and find_spec("imageio_ffmpeg") is None, reason="needs ffmpeg")
def test_a_streamed_camera_announces_its_stream(live: LiveSimulator) -> None:
    with (
        VideoStream(live, "rov", Endpoint("127.0.0.1", 5601), "down") as video,
        MavlinkVehicle(live, Endpoint("127.0.0.1", 0, "udpin"), (), action=None, video=video) as vehicle,
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
    assert "pitch 120 deg" in station.receive("STATUSTEXT").text
    assert pitch_yaw(station, 0, 0, flags=dialect.GIMBAL_MANAGER_FLAGS_YAW_LOCK) == FAILED
    assert station.command(dialect.MAV_CMD_DO_MOUNT_CONTROL, -45, 0, 0, 0, 0, 0, 2) == DONE
    station.receive("NAMED_VALUE_FLOAT", lambda value: value.name == "CamTilt" and abs(value.value - 0.25) < 0.001)


def test_one_station_at_a_time_controls_the_gimbal(other: Station, station: Station) -> None:
    assert station.command(dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, -2, -2, -1, -1) == DONE
    assert station.receive("GIMBAL_MANAGER_STATUS").primary_control_sysid == 255
    assert pitch_yaw(other, 10, 0) == DENIED
    assert pitch_yaw(station, 10, 0) == DONE
    assert station.command(dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, -3, -3, -1, -1) == DONE
    assert pitch_yaw(other, 5, 0) == DONE


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


def test_the_stations_pilot_ends_a_turn(vehicle: MavlinkVehicle, station: Station) -> None:
    assert vehicle._action is not None
    helm = vehicle._action.steering.helm
    assert pitch_yaw(station, math.nan, math.nan, 1, 0) == DONE
    lease = helm.take(Source.PILOT, "Ada")
    try:
        assert "Ada has the controls" in station.receive("STATUSTEXT").text
    finally:
        lease.end()


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

    def efforts(*pulses: int) -> list[float]:
        """Send a message, whose effect ends 0.1 s later."""
        station.mav.rc_channels_override_send(1, 1, *pulses)
        return [float(effort) for effort in live.rov.effort[:2]]

    until(lambda: efforts(*keep, forward, *[65535] * 3) == pytest.approx([0.5, 0.0]))
    until(lambda: efforts(*keep, 65535, 1600, 65535, 65535) == pytest.approx([0.5, -0.25]))  # forward stays
    station.mav.rc_channels_override_send(1, 1, *keep, 0, 0, 65535, 65535)
    until(lambda: not np.any(live.rov.effort))
    station.mav.rc_channels_override_send(1, 1, 5, *[65535] * 7)
    assert "chan1_raw 5 us: must be in" in station.receive("STATUSTEXT", lambda text: "chan1" in text.text).text


def test_targets_are_global_local_or_offsets(live: LiveSimulator, station: Station) -> None:
    station.arm()
    assert station.mode(GUIDED) == DONE
    here = station.receive("LOCAL_POSITION_NED")
    at = station.receive("GLOBAL_POSITION_INT")
    mask = 0b110111111000
    north_e7 = round(2.0 / 111_000 * 1e7)
    station.mav.set_position_target_global_int_send(0, 1, 1, 6, mask, at.lat + north_e7, at.lon, -4.0, *[0.0] * 8)
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached")
    now = station.receive("LOCAL_POSITION_NED")
    assert (now.x, now.y, now.z) == pytest.approx((here.x + 2, here.y, 4.0), abs=0.11)
    station.mav.set_position_target_local_ned_send(0, 1, 1, 1, mask, here.x + 2.4, here.y, 4.0, *[0.0] * 8)
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached")
    now = station.receive("LOCAL_POSITION_NED")
    assert now.x == pytest.approx(here.x + 2.4, abs=0.11), "a target half a metre ahead is flown to, too"
    until(lambda: station.receive("LOCAL_POSITION_NED").x == pytest.approx(here.x + 2.4, abs=0.02))
    station.mav.set_position_target_local_ned_send(0, 1, 1, 7, mask, 0, 0, -1.0, *[0.0] * 8)  # Cockpit's way up
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached")
    assert station.receive("LOCAL_POSITION_NED").z == pytest.approx(now.z - 1, abs=0.11)
    values = (-1, 1, 0, math.nan, at.lat, at.lon, -3.0)
    assert station.command(dialect.MAV_CMD_DO_REPOSITION, *values, as_int=True) == DONE
    station.receive("STATUSTEXT", lambda text: text.text == "Target reached")
    assert station.receive("LOCAL_POSITION_NED").x == pytest.approx(here.x, abs=0.11)
    heard = len(station.heard)
    for k in range(40):
        station.mav.set_position_target_local_ned_send(0, 1, 1, 2, mask, float(k), 0, -1, *[0.0] * 8)
    for frame, words in ((2, "frame 2"), (1, "must be numbers")):
        station.mav.set_position_target_local_ned_send(0, 1, 1, frame, mask, math.nan, 0, 1, *[0.0] * 8)
        station.receive("STATUSTEXT", lambda text, words=words: words in text.text)
    texts = [each.text for each in station.heard[heard:] if each.get_type() == "STATUSTEXT"]
    assert 1 <= sum("frame 2" in text for text in texts) <= 4


def test_a_reason_is_sent_once_until_a_target_is_accepted_or_10_s_have_passed() -> None:
    now_s = 5.0
    refusals = Refusals(lambda: now_s)
    assert refusals.is_new("target: alt = 3 m: must be at most 0")
    assert not refusals.is_new("target: alt = nan m: must be at most 0") and refusals.is_new("must be in mode GUIDED")
    now_s = 14.9
    assert not refusals.is_new("target: alt = -2.5e+03 m: must be at most 0")
    now_s = 15.1
    assert refusals.is_new("target: alt = 7 m: must be at most 0")
    refusals.accepted()
    assert refusals.is_new("target: alt = 7 m: must be at most 0")


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
    assert interval(station, dialect.MAVLINK_MSG_ID_WIND_COV, 1e6) == DENIED
    assert interval(station, ahrs, math.nan) == DENIED
    station.mav.request_data_stream_send(1, 1, 11, 2, 1)  # EXTRA2 at 2 Hz
    station.poll()
    assert 3 <= counted(station, "VFR_HUD", 2.0) <= 6
    assert interval(station, dialect.MAVLINK_MSG_ID_VFR_HUD, 0) == DONE
    assert 18 <= counted(station, "VFR_HUD", 2.0) <= 22
