"""Every field of every message is filled by something, or has a reason why it is always zero, false or empty."""

import math
from typing import Any

import numpy as np
import pytest

from channel_tools import require_writable, table
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.families.covariance import variance
from uwsim.channels.ros.message_types import fields

TOUCHES = "the vehicle touches nothing"
ABSENT, IDLE, LINK = "there is none", "not in this run", "this scenario has no link"
PANEL = "of a vehicle without trouble"
REASONS = {
    "AccelWithCovarianceStamped.accel.accel.angular.x": "not measured by an IMU",
    "AccelWithCovarianceStamped.accel.accel.angular.y": "not measured by an IMU",
    "AccelWithCovarianceStamped.accel.accel.angular.z": "not measured by an IMU",
    "BatteryState.cell_temperature": ABSENT, "BatteryState.cell_voltage": ABSENT, "BatteryState.location": ABSENT,
    "BatteryState.serial_number": ABSENT, "BatteryState.power_supply_health": "0 is unknown",
    "BatteryState.power_supply_status": "0 is unknown", "BatteryState.power_supply_technology": "0 is unknown",
    "Bool.data": IDLE,  # contact
    "CameraInfo.binning_x": "0 is none", "CameraInfo.binning_y": "0 is none", "CameraInfo.roi.do_rectify": "whole",
    "CameraInfo.roi.height": "whole", "CameraInfo.roi.width": "whole", "CameraInfo.roi.x_offset": "whole",
    "CameraInfo.roi.y_offset": "whole",
    "DVL.beams.nsd": "not modelled", "DVL.beams.rssi": "not modelled", "DVL.status": "0 is no error",
    "DVL.form": "of a driver's JSON",
    "Dvl.dvl_type": "0 is piston", "Range.radiation_type": "0 is ultrasound",
    "Image.is_bigendian": "little-endian", "PointCloud2.is_bigendian": "little-endian",
    "ProjectedSonarImage.image.is_bigendian": "little-endian",
    "JointState.effort": "optional, not simulated", "JointState.velocity": "optional, not simulated",
    "JointState.header.frame_id": "joints have none", "Link.header.frame_id": "it has none",
    "LaserScan.intensities": "optional; /points has the levels of the echoes", "LaserScan.range_min": "from the head",
    "LaserScan.time_increment": "all beams at once",
    "Link.bytes_delivered": LINK, "Link.closing_speed": LINK, "Link.delay": LINK, "Link.delivered": LINK,
    "Link.fault_loss": LINK, "Link.late": LINK, "Link.lost": LINK, "Link.queue_station": LINK,
    "Link.queue_vehicle": LINK, "Link.sent": LINK, "Link.silence": LINK, "Link.silence_at_station": LINK,
    "Link.snr": LINK,
    "MapChanges.snapshot": "of the first message to a subscriber alone",
    "PointStamped.header.stamp.nanosec": "the USBL's fixes are a second apart",
    "PoseWithCovarianceStamped.pose.pose.orientation.x": "not measured by depth",
    "PoseWithCovarianceStamped.pose.pose.orientation.y": "not measured by depth",
    "PoseWithCovarianceStamped.pose.pose.orientation.z": "not measured by depth",
    "ProjectedSonarImage.beam_directions.x": "its fan is in the plane of y and z",
    "Range.field_of_view": "one ray", "Range.min_range": "from the sensor",
    "Forces.contact_forces": TOUCHES, "Forces.contact_others": TOUCHES, "Forces.contact_points": TOUCHES,
    "Forces.contact_links": TOUCHES, "Forces.contact_other_links": TOUCHES,
    "Telemetry.alarms": PANEL, "Telemetry.collision_warning": PANEL, "Telemetry.collisions": PANEL,
    "Telemetry.failsafe": PANEL, "Telemetry.failsafe_cause": PANEL, "Telemetry.range_warning": PANEL,
    "Telemetry.holds": IDLE, "Telemetry.hold_targets": IDLE, "Telemetry.hold_note": IDLE,  # see test_holds.py
    "Telemetry.lamps": IDLE, "Telemetry.thrusters": "forces drive this vehicle",
    "TwistWithCovarianceStamped.twist.twist.angular.x": "not measured by a DVL",
    "TwistWithCovarianceStamped.twist.twist.angular.y": "not measured by a DVL",
    "TwistWithCovarianceStamped.twist.twist.angular.z": "not measured by a DVL",
}  # fmt: skip


def note(message: Any, path: str, filled: dict[str, bool]) -> None:
    """Note for each leaf of a message whether it has any value but zero."""
    for field in fields(message.__msgtype__, 2):
        if field.attribute is None:
            continue
        value, name = getattr(message, field.attribute), f"{path}.{field.name}"
        parts = value if isinstance(value, list | tuple) else [value]
        if parts and hasattr(parts[0], "__msgtype__"):
            for part in parts:
                note(part, name, filled)
        else:
            has_value = bool(np.any(value)) if isinstance(value, np.ndarray) else any(bool(part) for part in parts)
            filled[name] = filled.get(name, False) or has_value


def test_each_message_can_be_written_and_fields_that_are_always_zero_have_a_reason() -> None:
    sim, filled = Simulator("pool", seed=3), dict[str, bool]()
    _ = sim.rov.estimate
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, yaw=0.2, heave=-0.2)
    sim.rov.sonar.aim(-0.4)
    channels, read = [channel for channel in Table(sim).channels if channel.direction == "out"], set()
    for _ in range(2):
        sim.advance(1.25)
        for channel in channels:
            message = require_writable(channel, sim)
            if message is not None:
                read.add(channel.name)
                note(message, channel.type.split("/")[-1], filled)
    assert read == {channel.name for channel in channels}
    zero = {name for name, has_value in filled.items() if not has_value}
    assert zero == REASONS.keys(), (zero - REASONS.keys(), REASONS.keys() - zero)


@pytest.fixture(scope="module")
def sim() -> Simulator:
    sim = Simulator("pool", seed=3)
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, yaw=0.3)
    sim.advance(3.0)
    return sim


def test_depth_is_a_height_in_odom_with_its_own_variance(sim: Simulator) -> None:
    found = table(sim, origin="published")
    message = found["depth/pose"].read(sim)
    assert message.header.frame_id == "odom"
    assert message.pose.pose.position.z == pytest.approx(75.3 - found["depth"].read(sim).data)
    diagonal = message.pose.covariance.reshape(6, 6).diagonal()
    mount = sim.scenario.vehicles[0].model.sensors["depth"]
    assert diagonal[2] == pytest.approx(variance(mount, "depth", mount.rate_hz, sim.time_s), rel=0.1)
    assert (np.delete(diagonal, 2) >= 1e6).all(), "nothing else is measured"


def test_a_heading_is_a_yaw_and_says_that_nothing_else_is_known(sim: Simulator) -> None:
    message = table(sim)["compass/imu"].read(sim)
    turn = message.orientation
    yaw = math.atan2(2.0 * turn.w * turn.z, 1.0 - 2.0 * turn.z**2)
    x, y = sim.rov.pose.world_from_body[:2, 0]
    assert math.remainder(yaw - math.atan2(y, x), math.tau) == pytest.approx(0.0, abs=0.1), "but for its errors"
    assert message.angular_velocity_covariance[0] == message.linear_acceleration_covariance[0] == -1.0  # REP 145


def test_a_dvl_is_also_a_twist_in_its_own_frame(sim: Simulator) -> None:
    found = table(sim)
    twist, dvl = found["dvl/twist"].read(sim), found["dvl"].read(sim)
    assert twist.header.frame_id == dvl.header.frame_id == "dvl_link"
    assert twist.twist.twist.linear == dvl.velocity
    np.testing.assert_array_equal(twist.twist.covariance.reshape(6, 6)[:3, :3].ravel(), dvl.velocity_covar)
    depth_m = -sim.rov.pose.position_world_m[2]
    assert dvl.sound_speed == pytest.approx(sim.world.water.sound_speed_m_s(-depth_m), abs=0.1)


def test_an_imaging_sonar_reports_the_speed_of_sound_at_its_head(sim: Simulator) -> None:
    found = table(sim)
    for name, sonar in sim.rov.imaging_sonars.items():
        speed_m_s = sim.world.water.sound_speed_m_s(sonar.world_from_sonar[2, 3])
        message = found[f"{name}/image"].read(sim)
        assert message.ping_info.sound_speed == pytest.approx(speed_m_s, abs=0.1), name
