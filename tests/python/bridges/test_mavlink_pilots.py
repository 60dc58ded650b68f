"""The owner of the sticks, their gain; modes that are kept; missions that go on; reports meanwhile."""

import math
import threading
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from mavlink_station import ALT_HOLD, DONE, GUIDED, MANUAL, Station
from uwsim.bridges.actions import goal
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.bridges.mavlink.modes import AUTO, STABILIZE, SURFACE
from uwsim.bridges.mavlink.settings import Settings
from uwsim.bridges.mavlink.stations import DISARM, NOTHING, WARN, Stations
from uwsim.live import LiveSimulator
from uwsim.mapping.files.georeference import Home
from waiting import until

HOME = Home(33.810313, -118.393867)
PREARM, GPS, MOTORS, AHRS, BATTERY = 1 << 28, 1 << 5, 1 << 15, 1 << 21, 1 << 25


def test_the_first_station_that_arms_has_the_sticks(live: LiveSimulator, other: Station, station: Station) -> None:
    assert station.arm() == DONE and station.mode(MANUAL) == DONE
    assert other.arm() == DONE  # which changes nothing
    until(lambda: pushes(station, 1000, 0) and live.rov.effort[0] == pytest.approx(0.5))  # JS_GAIN_DEFAULT
    for _ in range(3):
        other.mav.manual_control_send(1, 0, 1000, 500, 0, 1 << 6)
        other.mav.rc_channels_override_send(1, 1, *[1900] * 8)
    text = other.receive("STATUSTEXT", lambda each: "refused" in each.text)
    assert text.text.startswith("MANUAL_CONTROL: system 254: refused") and text.severity == dialect.MAV_SEVERITY_WARNING
    assert not live.rov.effort[1]
    assert other.arm(False) == DONE, "anybody may stop it"
    assert other.arm() == DONE and other.mode(MANUAL) == DONE
    until(lambda: pushes(other, 0, -1000) and live.rov.effort[1] == pytest.approx(0.5))


def test_an_axis_that_is_not_given_is_at_rest_and_a_fault_of_the_sticks_is_reported_once(
    live: LiveSimulator, station: Station
) -> None:
    assert station.arm() == DONE and station.mode(MANUAL) == DONE
    until(lambda: pushes(station, 32767, 1000) and live.rov.effort[1] == pytest.approx(-0.5))
    assert live.rov.effort[0] == live.rov.effort[2] == 0.0
    station.drain()
    for _ in range(5):
        station.mav.manual_control_send(1, 2000, 0, 500, 0, 0)
    (text,) = (text for text in texts_of_a_second(station) if "MANUAL_CONTROL" in text)
    assert "MANUAL_CONTROL: x 2000: must be in" in text and "or 32767 for none" in text


def test_a_lost_hold_is_told_once_in_words(live: LiveSimulator, station: Station) -> None:
    assert station.arm() == DONE and station.mode(ALT_HOLD) == DONE
    until(lambda: "depth" in live.rov.holds.targets)
    station.drain()
    live.command("set_wrench", vehicle="rov", force_body_n=(0.0, 0.0, 0.0)).result()
    until(lambda: not live.rov.holds.targets)
    heard = texts_of_a_second(station)
    assert not any("=" in text or "hold_ends" in text for text in heard), heard
    assert sum("hold ended" in text for text in heard) == 1, heard


def texts_of_a_second(station: Station) -> list[str]:
    """Return the texts, with their parts joined, that arrive within a second of simulated time."""
    texts: list[str] = []
    begin = station.receive("LOCAL_POSITION_NED")
    station.receive("LOCAL_POSITION_NED", lambda place: place.time_boot_ms > begin.time_boot_ms + 1000)
    for message in station.heard:
        if message.get_type() == "STATUSTEXT":
            texts += [""] if not message.chunk_seq else []
            texts[-1] += message.text
    return texts


def pushes(station: Station, x: int, y: int) -> bool:
    """Move the sticks, whose effect ends 0.1 s later."""
    station.mav.manual_control_send(1, x, y, 500, 0, 0)
    return True


@pytest.mark.parametrize(("action", "then"), [(0, NOTHING), (1, WARN), (2, DISARM)])
def test_a_silent_station_loses_the_sticks(action: int, then: int) -> None:
    settings, texts, now = Settings(), list[tuple[str, int]](), [0.0]
    settings.set("FS_GCS_ENABLE", action)
    settings.set("FS_GCS_TIMEOUT", 3.0)
    stations = Stations(settings, lambda text, severity=4, /: texts.append((text, severity)), lambda: now[0])
    stations.give_to((255, 190))
    now[0] = 2.9
    assert stations.silent_action() == NOTHING and stations.owner == (255, 190)
    stations.hear((254, 1))  # another is there, which does not help
    now[0] = 3.1
    assert stations.silent_action() == then and stations.owner is None
    assert texts == ([("station 255 is silent for 3 s", 2)] if action else [])
    assert stations.silent_action() == NOTHING, "once"
    assert stations.require((254, 1), "MANUAL_CONTROL") and stations.owner == (254, 1)


def test_the_gain_changes_as_ardusubs(live: LiveSimulator, station: Station) -> None:
    for button, gain in ((11, 0.75), (11, 1.0), (11, 1.0), (12, 0.75), (12, 0.5)):
        station.mav.manual_control_send(1, 0, 0, 500, 0, 1 << button)
        text = station.receive("STATUSTEXT", lambda each: each.text.startswith("#Gain"))
        assert (text.text, text.severity) == (f"#Gain is {100 * gain:.0f}%", dialect.MAV_SEVERITY_INFO)
        station.mav.manual_control_send(1, 0, 0, 500, 0, 0)
    station.receive("NAMED_VALUE_FLOAT", lambda value: value.name == "PilotGain" and value.value == 0.5)
    station.mav.param_set_send(1, 1, b"JS_THR_GAIN", 9.0, 9)
    assert station.receive("PARAM_VALUE").param_value == 1.0


def test_disarming_keeps_the_mode(live: LiveSimulator, station: Station) -> None:
    assert station.arm() == DONE and station.mode(ALT_HOLD) == DONE
    station.receive("HEARTBEAT", lambda beat: beat.custom_mode == ALT_HOLD and beat.base_mode & 128)
    assert station.arm(False) == DONE
    station.receive("HEARTBEAT", lambda beat: beat.custom_mode == ALT_HOLD and not beat.base_mode & 128)
    assert not any(live.rov.holds.targets), "nothing steers while it is disarmed"
    assert station.arm() == DONE
    until(lambda: "depth" in live.rov.holds.targets)


def upload(station: Station, *items: tuple[int, tuple[float, ...], tuple[float, float, float] | None]) -> int:
    """Upload items, each a command, its parameters and a place; return the result."""
    station.mav.mission_count_send(1, 1, len(items) + 1)
    for seq, (command, parameters, at) in enumerate([(16, (), None), *items]):
        station.receive("MISSION_REQUEST", lambda request, seq=seq: request.seq == seq)
        lat, lon = HOME.degrees(np.array(at)) if at else (0.0, 0.0)
        values = [*parameters, *[0.0] * (4 - len(parameters))]
        place = round(1e7 * lat), round(1e7 * lon), at[2] if at else 0.0
        station.mav.mission_item_int_send(1, 1, seq, 6, command, 0, 1, *values, *place)
    return int(station.receive("MISSION_ACK").type)


def test_a_mission_goes_on_where_it_was_left(live: LiveSimulator, station: Station) -> None:
    x, y, _ = live.rov.pose.position_world_m
    assert upload(station, (16, (), (x + 1, y, -3.0)), (17, (), (x + 2, y, -3.0)), (16, (), (x + 3, y, -2.0))) == 0
    assert station.arm() == DONE and station.mode(AUTO) == DONE
    station.receive("MISSION_ITEM_REACHED", lambda item: item.seq == 1)
    current = station.receive("MISSION_CURRENT", lambda item: item.seq == 2)
    assert (current.total, current.mission_state) == (3, dialect.MISSION_STATE_ACTIVE)
    assert upload_is_refused(station)
    assert station.mode(ALT_HOLD) == DONE
    paused = station.receive("MISSION_CURRENT", lambda item: item.mission_state == dialect.MISSION_STATE_PAUSED)
    assert paused.seq == 2
    assert station.mode(AUTO) == DONE
    station.receive("MISSION_CURRENT", lambda item: item.mission_state == dialect.MISSION_STATE_ACTIVE)
    assert station.command(dialect.MAV_CMD_DO_SET_MISSION_CURRENT, 3) == DONE  # away from an endless loiter
    station.receive("MISSION_ITEM_REACHED", lambda item: item.seq == 3)
    station.receive("MISSION_CURRENT", lambda item: item.mission_state == dialect.MISSION_STATE_COMPLETE)
    done = station.receive("STATUSTEXT", lambda text: "complete" in text.text)
    assert done.severity == dialect.MAV_SEVERITY_INFO
    assert station.command(dialect.MAV_CMD_DO_SET_MISSION_CURRENT, 4) == dialect.MAV_RESULT_DENIED


def test_a_flight_that_ends_late_changes_no_state_of_the_next(
    live: LiveSimulator, station: Station, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the simulator is paused, the one before cannot notice its end, for which the next does not wait."""
    monkeypatch.setattr(goal, "CLOSE_S", 600.0)
    x, y, _ = live.rov.pose.position_world_m
    assert upload(station, (17, (), (x, y, -3.0))) == 0
    assert station.arm() == DONE and station.mode(AUTO) == DONE
    station.receive("MISSION_CURRENT", lambda item: item.mission_state == dialect.MISSION_STATE_ACTIVE)
    live.pause()
    try:
        until(lambda: station.command(dialect.MAV_CMD_DO_SET_MISSION_CURRENT, 1) == DONE and flights() > 1)
    finally:
        live.resume()
    until(lambda: flights() == 1)
    station.drain()
    current = station.receive("MISSION_CURRENT")
    assert current.mission_state == dialect.MISSION_STATE_ACTIVE


def flights() -> int:
    return sum(thread.name == "uwsim-fly_path" for thread in threading.enumerate())


def upload_is_refused(station: Station) -> bool:
    station.mav.mission_count_send(1, 1, 2)
    return bool(station.receive("MISSION_ACK").type == dialect.MAV_MISSION_DENIED)


def test_surface_ends_in_depth_hold(live: LiveSimulator, station: Station) -> None:
    assert station.arm() == DONE
    assert station.command(dialect.MAV_CMD_NAV_LAND) == DONE
    station.receive("HEARTBEAT", lambda beat: beat.custom_mode == SURFACE)
    station.receive("HEARTBEAT", lambda beat: beat.custom_mode == ALT_HOLD)
    assert live.rov.pose.position_world_m[2] > -0.4


def test_attitude_targets_turn_and_climb(live: LiveSimulator, vehicle: MavlinkVehicle, station: Station) -> None:
    assert station.arm() == DONE and station.mode(GUIDED) == DONE
    q = Rotation.from_euler("ZYX", [math.radians(120), 0, 0]).as_quat(scalar_first=True)
    begun = live.rov.pose.position_world_m[2]

    def has_turned() -> bool:
        station.mav.set_attitude_target_send(0, 1, 1, 0b111, q, 0, 0, 0, 0.0)
        station.poll()
        turned = math.remainder(math.pi / 2 - math.radians(120) - live.rov.pose.yaw_rad, math.tau)
        return abs(turned) < 0.1 and live.rov.pose.position_world_m[2] < begun - 1

    until(has_turned)
    for mask, thrust in ((1 << 7, 0.5), (0, math.nan)):
        has_turned()  # a reason is a text once, until a target is accepted
        station.mav.set_attitude_target_send(0, 1, 1, mask, q, 0, 0, 0, thrust)
        station.receive("STATUSTEXT", lambda text: "SET_ATTITUDE_TARGET" in text.text)
    velocities = 0b110111000111
    for mask, speed in ((velocities, math.nan), (velocities, 1e6), (velocities & ~(1 << 6), 0.1), (1, 0.1)):
        has_turned()
        before = vehicle._flight._is_steering, live.rov.helm.leases
        station.mav.set_position_target_local_ned_send(0, 1, 1, 1, mask, 0, 0, -3, speed, *[0.0] * 7)
        station.receive("STATUSTEXT", lambda text: "target: " in text.text)
        assert (vehicle._flight._is_steering, live.rov.helm.leases) == before


def test_targets_of_depth_and_heading_alone_are_those_of_the_holds(live: LiveSimulator, station: Station) -> None:
    """ArduSub steers to them in ALT_HOLD, as its own example does; elsewhere they need GUIDED."""
    assert station.arm() == DONE and station.mode(STABILIZE) == DONE
    q = Rotation.from_euler("ZYX", [math.radians(45), 0, 0]).as_quat(scalar_first=True)
    depth = 1, 1, 5, 0xDFB, 0, 0, -1.5, *[0.0] * 8
    station.mav.set_position_target_global_int_send(0, *depth)
    station.receive("STATUSTEXT", lambda text: "must be in mode GUIDED" in text.text)
    assert station.mode(ALT_HOLD) == DONE

    def is_there() -> bool:
        station.mav.set_position_target_global_int_send(0, *depth)
        station.mav.set_attitude_target_send(0, 1, 1, 1 << 6, q, 0, 0, 0, 0.0)
        station.poll()
        turned = math.remainder(math.pi / 4 - live.rov.pose.yaw_rad, math.tau)
        return abs(turned) < 0.05 and abs(live.rov.pose.position_world_m[2] + 1.5) < 0.1

    until(is_there)
    station.mav.set_position_target_global_int_send(0, 1, 1, 5, 0xDFB, 0, 0, 1.5, *[0.0] * 8)
    station.receive("STATUSTEXT", lambda text: "alt 1.5 m" in text.text)


def latest(station: Station, kind: str) -> Any:
    station.heard.clear()
    return station.receive(kind)


def test_what_is_reported_is_what_is(live: LiveSimulator, station: Station) -> None:
    bits = PREARM | GPS | MOTORS | AHRS | BATTERY | 0x7
    status = latest(station, "SYS_STATUS")
    assert status.onboard_control_sensors_present & bits == bits == status.onboard_control_sensors_health & bits
    fence = dialect.MAV_SYS_STATUS_GEOFENCE  # whose health, while there is none, is not that of a breach
    assert status.onboard_control_sensors_health & fence and not status.onboard_control_sensors_present & fence
    assert station.command(dialect.MAV_CMD_DO_FLIGHTTERMINATION, 1) == DONE
    station.receive("SYS_STATUS", lambda each: not each.onboard_control_sensors_health & PREARM)
    assert station.command(dialect.MAV_CMD_DO_FLIGHTTERMINATION, 0) == DONE
    assert station.arm() == DONE and station.mode(MANUAL) == DONE
    assert latest(station, "EXTENDED_SYS_STATE").landed_state == dialect.MAV_LANDED_STATE_IN_AIR
    home = station.request("HOME_POSITION")
    here = live.rov.pose.position_world_m
    assert np.linalg.norm(HOME.world_m(home.latitude / 1e7, home.longitude / 1e7, 0)[:2] - here[:2]) < 1.0

    def steers() -> bool:
        station.mav.manual_control_send(1, 1000, 0, 500, 0, 0)
        channels, servos = latest(station, "RC_CHANNELS"), latest(station, "SERVO_OUTPUT_RAW")
        commands = [thruster.command for thruster in live.rov.thrusters.values()]
        pulses = [getattr(servos, f"servo{k}_raw") for k in range(1, len(commands) + 1)]
        return channels.chan5_raw == 1700 and pulses == [round(1500 + 400 * command) for command in commands]

    until(steers)
    imu = latest(station, "SCALED_IMU")
    assert imu.zacc == pytest.approx(-1000, abs=60)  # at rest, 1 g upwards, in thousandths
    fix, report = latest(station, "GPS_RAW_INT"), latest(station, "EKF_STATUS_REPORT")
    assert fix.fix_type == 3 and report.flags & dialect.EKF_POS_HORIZ_ABS
    odometry = station.request("ODOMETRY")
    turn = Rotation.from_quat(odometry.q, scalar_first=True).as_matrix()
    assert turn[:, 0] @ [0, 0, 1] == pytest.approx(0.0, abs=0.2)  # the nose is level
    assert (odometry.frame_id, odometry.child_frame_id) == (1, 12)


@pytest.mark.parametrize(("action", "armed", "mode"), [(2, 0, MANUAL), (3, 128, ALT_HOLD)])
def test_what_follows_a_silence(
    live: LiveSimulator, vehicle: MavlinkVehicle, station: Station, action: int, armed: int, mode: int
) -> None:
    settings = {"FS_GCS_ENABLE": (action, 1), "FS_GCS_TIMEOUT": (0.3, 5.0)}
    for name, (value, _) in settings.items():
        station.mav.param_set_send(1, 1, name.encode(), value, 9)
        assert station.receive("PARAM_VALUE", lambda sent, name=name: sent.param_id == name).param_value > 0.2
    assert station.mode(MANUAL) == DONE and station.arm() == DONE
    station.receive("STATUSTEXT", lambda text: "is silent for 0.3 s" in text.text)
    station.receive("HEARTBEAT", lambda beat: (beat.base_mode & 128, beat.custom_mode) == (armed, mode))
    for name, (_, value) in settings.items():
        station.mav.param_set_send(1, 1, name.encode(), value, 9)
        station.receive("PARAM_VALUE", lambda sent, name=name: sent.param_id == name)
