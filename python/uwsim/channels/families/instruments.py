"""Sensor and battery channels. KINDS lists the ROS message type and a message builder for each kind of sensor."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.quaternions import about_z
from uwsim.channels.channel import Channel, Delivery, OverLink
from uwsim.channels.families.covariance import UNKNOWN, independent, is_steady, isotropic, of_velocity, variance
from uwsim.channels.families.positioning import ins_odometry, nav_sat_fix
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.channels.source import Source
from uwsim.channels.taped import Make, Rows, Stretch, Taped, Track
from uwsim.instruments.sensors import Sample
from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario import Scenario
from uwsim.scenario.georeference import georeference
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind
from uwsim.simulator.simulator import Simulator

DEFAULT_HZ = 10.0  # for sensors without a rate
BATTERY_HZ = 1.0
ULTRASOUND = 0
DOWN = np.array([1.0, -1.0, -1.0])  # turns x ahead, y to port, z up into x ahead, y to starboard, z down
UNOBSERVED = 1e6  # variance of quantities that a sensor does not measure, in their unit squared
DVL_MODE_BOTTOM, DVL_MODE_WATER = 1, 2
GPS = "gps"
SAMPLED = Delivery(is_sampled=True)


class Errors(NamedTuple):
    """A sensor's error statistics at one time. steady: the variances that no time changes, as far as known."""

    mount: SensorMount
    rate_hz: float
    time_s: float
    steady: dict[str, float]
    sound_speed_m_s: float = math.nan  # for a DVL, at its vehicle's depth
    frame_id: str = ""  # the sensor's own
    place: Georeference = Georeference()  # the world's, for a GPS

    def variance(self, channel: str) -> float:
        """Return the error variance of a channel [unit^2]."""
        found = self.steady.get(channel)
        if found is None:
            found = variance(self.mount, channel, self.rate_hz, self.time_s)
            if is_steady(self.mount, channel):
                self.steady[channel] = found
        return found


Write = Callable[[Any, Any, Errors], Any]


class FilterInput(NamedTuple):
    """A second message for one kind of sensor, of a type that filters accept as input.

    write(value, header, errors, origin_m): builds the message; origin_m is the world's origin in odom. frame: the
    message's frame; "" means the sensor's frame. even_invalid: as for Kind.
    """

    suffix: str
    type: str
    description: str
    write: Callable[[Any, Any, Errors, Any], Any]
    frame: str = ""
    even_invalid: bool = False
    takes_columns: bool = False


class Kind(NamedTuple):
    """The publication of one kind of sensor. write(value, header, errors): builds a message.

    even_invalid: whether samples without an echo are published as well. takes_columns: whether `write` also makes a
    message of columns, from a reading and a header of columns.
    """

    type: str
    write: Write
    even_invalid: bool = False
    takes_columns: bool = False


def sensor_channels(source: Source, sim: Simulator) -> list[Channel]:
    """Return the channels of a vehicle's sensors and battery. Each sensor's channel has the sensor's name."""
    found = [
        Channel(
            source.topic("battery_state"), "sensor_msgs/msg/BatteryState", "out",
            "remaining charge; only the percentage if the battery is modelled as a mission time",
            rate_hz=BATTERY_HZ, over_link=OverLink(),
            read=lambda sim: _battery(source, sim),
        )
    ]  # fmt: skip
    for name, sensor in source.of(sim).sensors.items():
        kind = _kind(sensor.kind)
        if sensor.kind == GPS and georeference(sim.scenario).crs is None:
            continue  # its message has latitude and longitude
        if kind is not None:
            frame_id = source.frame(f"{name}_link")
            found.append(
                Channel(
                    source.topic(name), kind.type, "out", sensor.meaning, rate_hz=sensor.rate_hz or DEFAULT_HZ,
                    frame_id=frame_id, over_link=OverLink(), delivery=SAMPLED,
                    read=_reader(source, name, kind, frame_id), taped=_taped(source, name, kind, frame_id),
                )
            )  # fmt: skip
        if sensor.kind in FILTER_INPUTS:
            found.append(filter_input(source, name, sensor.rate_hz or DEFAULT_HZ, FILTER_INPUTS[sensor.kind]))
    return found


def _kind(name: str) -> Kind | None:
    """Return the publication of a kind of sensor, or None if it has none."""
    kind = sensor_kind(name)
    if not isinstance(kind, DerivedKind) or kind.write is None:
        return KINDS.get(name)
    type_, write = kind.type, kind.write
    channels = tuple(kind.channels)

    def message(value: Any, header: Any, errors: Errors) -> Any:
        return build.message(type_, **write(value, header, {each: errors.variance(each) for each in channels}))

    return Kind(type_, message)


def filter_input(
    source: Source, name: str, rate_hz: float, input_: FilterInput, delivery: Delivery = SAMPLED
) -> Channel:
    """Return the channel of a sensor's values in the form that filters such as robot_localization accept."""
    frame_id = source.frame(input_.frame or f"{name}_link")

    def write(value: Any, header: Any, errors: Errors) -> Any:
        return input_.write(value, header, errors, source.origin_m)

    kind = Kind(input_.type, write, input_.even_invalid, input_.takes_columns)
    return Channel(
        source.topic(f"{name}/{input_.suffix}"), input_.type, "out", input_.description, rate_hz=rate_hz,
        frame_id=frame_id, over_link=OverLink(packing=""), delivery=delivery,
        read=_reader(source, name, kind, frame_id), taped=_taped(source, name, kind, frame_id),
    )  # fmt: skip


def _reader(source: Source, name: str, kind: Kind, frame_id: str) -> Callable[[Simulator], Any]:
    mounted = _Mounted(source, name, kind, frame_id)
    last: tuple[int, Any] = (-1, None)  # time of the sample, message

    def read(sim: Simulator) -> Any:
        """Return the message for the current sample: the same object as before while no other sample has arrived."""
        nonlocal last
        sensor = source.of(sim).sensors[name]
        if not sensor.on:
            return None
        sample: Sample[Any] = sensor.sample()
        message = mounted.message(sim, sample)
        if message is None:
            return None
        if sample.stamp_ns == last[0] and encode(message) == encode(last[1]):  # a reset may repeat the time alone
            return last[1]
        last = sample.stamp_ns, message
        return message

    return read


def _taped(source: Source, name: str, kind: Kind, frame_id: str) -> Taped | None:
    """Return how the messages of a sensor follow from a tape; None for kinds whose messages have no columns."""
    if not kind.takes_columns:
        return None

    def begin(sim: Simulator) -> Make | None:
        sensor, mount = source.of(sim).sensors[name], source.model(sim).sensors[name]
        if not (
            sensor.is_plain and all(is_steady(mount, channel) for channel in _core.sensor_kind(mount.kind).channels)
        ):
            return None
        mounted = _Mounted(source, name, kind, frame_id)
        mounted.look_up(sim)

        def make(tracks: Sequence[Rows]) -> Stretch:
            (rows,) = tracks
            is_sent = rows.valid if not kind.even_invalid else rows.valid | ~np.isfinite(rows.values[:, 0])
            sent = rows if is_sent.all() else rows.only(is_sent)
            return Stretch(sent.times_ns, mounted.write(sensor.reading_of(sent.values), sent.stamps_ns, 0.0))

        return make

    return Taped((Track(source.name, name),), begin)


def sample_messages(source: Source, sim: Simulator, name: str) -> Callable[[Simulator, Sample[Any]], Any]:
    """Return a function that makes the message for a sensor's sample, None if its channel does not publish it."""
    kind = _kind(source.of(sim).sensors[name].kind)
    if kind is None:
        return lambda sim, sample: None
    return _Mounted(source, name, kind, source.frame(f"{name}_link")).message


class _Mounted:
    """Builds the messages of one sensor, whose mount is looked up when the vehicle's parameters have changed."""

    def __init__(self, source: Source, name: str, kind: Kind, frame_id: str) -> None:
        self._source, self._name, self._kind, self._frame_id = source, name, kind, frame_id
        self._own_frame = source.frame(f"{name}_link")
        self._scenario: Scenario | None = None

    def message(self, sim: Simulator, sample: Sample[Any]) -> Any:
        """Return the message for a sample, or None if it is not published."""
        if not (sample.valid or (self._kind.even_invalid and _is_out_of_reach(sample.value))):
            return None
        if self._scenario is not sim.parameters.scenario:
            self.look_up(sim)
        speed_m_s = sim.world.water.sound_speed_m_s(_height_m(self._source, sim)) if self._is_doppler else math.nan
        return self.write(sample.value, sample.stamp_ns, sample.stamp_s, speed_m_s)

    def write(self, value: Any, stamp_ns: Any, time_s: float, speed_m_s: float = math.nan) -> Any:
        """Return the message for a reading, or that of columns for a reading and time stamps (n,) in columns.

        time_s: for its error statistics.
        """
        frame = self._own_frame
        errors = Errors(self._mount, self._rate_hz, time_s, self._steady, speed_m_s, frame, self._place)
        return self._kind.write(value, build.header(stamp_ns, self._frame_id), errors)

    def look_up(self, sim: Simulator) -> None:
        """Keep the mount as it is now."""
        self._scenario = sim.parameters.scenario
        self._mount = mount = self._source.model(sim).sensors[self._name]
        self._rate_hz = mount.rate_hz or 1.0 / sim.step_s
        self._is_doppler = mount.kind in ("dvl", "adcp")
        self._place = georeference(sim.scenario) if mount.kind == GPS else Georeference()
        self._steady: dict[str, float] = {}


def _height_m(source: Source, sim: Simulator) -> float:
    return min(float(source.of(sim).pose.position_world_m[2]), 0.0)


def _is_out_of_reach(value: Any) -> bool:
    """Return whether a sample is invalid because there was no echo or fix, rather than because it was lost."""
    for lock in ("bottom_lock", "water_lock", "fix"):
        if hasattr(value, lock):
            return bool(getattr(value, lock) == 0)
    return not math.isfinite(value)


def _battery(source: Source, sim: Simulator) -> Any:
    battery = source.of(sim).battery
    return build.message(
        "sensor_msgs/msg/BatteryState",
        header=build.header(sim.time_ns, source.frame("base_link")),
        voltage=battery.voltage_v,
        temperature=math.nan,
        current=-battery.current_a,
        charge=battery.charge_ah,
        capacity=battery.capacity_ah,
        design_capacity=battery.capacity_ah,
        percentage=0.01 * battery.percent,
        present=True,
    )


def _imu(value: Any, header: Any, errors: Errors) -> Any:
    """Return an Imu message. Its acceleration is the specific force, as in REP 145."""
    return build.message(
        "sensor_msgs/msg/Imu",
        header=header,
        orientation=build.quaternion(value.orientation_xyzw),
        orientation_covariance=isotropic(errors.variance("orientation")),
        angular_velocity=build.vector(value.angular_velocity_rad_s),
        angular_velocity_covariance=isotropic(errors.variance("angular_velocity")),
        linear_acceleration=build.vector(value.linear_acceleration_m_s2),
        linear_acceleration_covariance=isotropic(errors.variance("linear_acceleration")),
    )


def _range(value: float, header: Any, errors: Errors) -> Any:
    mount = errors.mount
    (range_max_m,) = mount.parameters.get("range_max_m") or (_default(mount.kind, "range_max_m"),)
    return build.message(
        "sensor_msgs/msg/Range",
        header=header,
        radiation_type=ULTRASOUND,
        max_range=range_max_m,
        range=value,
        variance=errors.variance("range" if mount.kind == "proximity" else mount.kind),
    )


def _default(kind: str, parameter: str) -> float:
    return float(_core.sensor_kind(kind).parameters[parameter].by_default)


def dvl_message(value: Any, header: Any, errors: Errors) -> Any:
    """Return a marine_acoustic_msgs/Dvl in axes with x forward, y to starboard and z along the beams."""
    velocity = DOWN * value.velocity_m_s
    slant, beams = _dvl_beams(errors.mount)
    good = np.isfinite(value.beam_ranges_m)
    velocity_variance = errors.variance("beam_velocity")
    return build.message(
        "marine_acoustic_msgs/msg/Dvl",
        header=header,
        velocity_mode=DVL_MODE_BOTTOM,
        velocity=build.vector(velocity),
        velocity_covar=_dvl_covariance(value, beams, errors),
        altitude=float(np.cos(slant) * value.beam_ranges_m[good].mean()) if good.any() else math.nan,
        course_gnd=math.atan2(velocity[1], velocity[0]),
        speed_gnd=math.hypot(velocity[0], velocity[1]),
        num_good_beams=int(good.sum()),
        sound_speed=errors.sound_speed_m_s,
        beam_ranges_valid=bool(good.any()),
        beam_velocities_valid=bool(good.any()),
        beam_unit_vec=[build.vector(beam) for beam in beams],
        range=np.asarray(value.beam_ranges_m, np.float64),
        range_covar=np.full(4, errors.variance("beam_range"), np.float32),
        beam_quality=good.astype(np.float32),
        beam_velocity=np.asarray(value.beam_velocities_m_s, np.float32),
        beam_velocity_covar=np.full(4, velocity_variance, np.float32),
    )


def _water_track(value: Any, header: Any, errors: Errors) -> Any:
    """Return a marine_acoustic_msgs/Dvl of the velocity through the water, in axes as of a DVL's bottom track."""
    velocity = DOWN * value.velocity_m_s
    return build.message(
        "marine_acoustic_msgs/msg/Dvl",
        header=header,
        velocity_mode=DVL_MODE_WATER,
        velocity=build.vector(velocity),
        velocity_covar=np.array([UNKNOWN, *[0.0] * 8]),
        altitude=math.nan,
        course_gnd=math.atan2(velocity[1], velocity[0]),
        speed_gnd=math.hypot(velocity[0], velocity[1]),
        num_good_beams=4 if value.water_lock else 0,
        sound_speed=errors.sound_speed_m_s,
    )


def _dvl_beams(mount: SensorMount) -> tuple[float, NDArray[np.float64]]:
    """Return `_beams_of` a DVL's mount."""
    (slant_deg,) = mount.parameters.get("beam_slant_deg") or (_default("dvl", "beam_slant_deg"),)
    (first_deg,) = mount.parameters.get("beam_azimuth_deg") or (_default("dvl", "beam_azimuth_deg"),)
    return _beams_of(slant_deg, first_deg)


def _dvl_covariance(value: Any, beams: NDArray[np.float64], errors: Errors) -> NDArray[np.float64]:
    """Return the row-major covariance (9,) of a velocity over the bed."""
    return of_velocity(beams[np.isfinite(value.beam_ranges_m)], errors.variance("beam_velocity"))


@lru_cache(64)
def _beams_of(slant_deg: float, first_deg: float) -> tuple[float, NDArray[np.float64]]:
    """Return a DVL's slant in radians and its beams' unit vectors (4, 3), in axes with z along the beams."""
    slant, first = np.radians((slant_deg, first_deg))
    azimuths = first + 0.5 * np.pi * np.arange(4)
    beams = np.array([np.sin(slant) * np.cos(azimuths), np.sin(slant) * np.sin(azimuths), -np.full(4, np.cos(slant))])
    return slant, DOWN * beams.T


def _plain(name: str, field: str, channel: str) -> Write:
    """Return a function that builds a message with a header, a scalar and its variance."""
    return lambda value, header, errors: build.message(
        name, header=header, variance=errors.variance(channel), **{field: value}
    )


def _bare(name: str, type_: type[float | bool]) -> Write:
    """Return a function that builds a message that contains only a scalar."""
    return lambda value, header, errors: build.message(
        name, data=value.astype(type_) if isinstance(value, np.ndarray) else type_(value)
    )


def _numbers(value: Any, header: Any, errors: Errors) -> Any:
    """Return a message with the quantities of a reading in order, for which no message of ROS exists."""
    return build.message("std_msgs/msg/Float64MultiArray", data=np.array(list(value.to_dict().values()), np.float64))


def _usbl(value: Any, header: Any, errors: Errors) -> Any:
    """Return a message with the position relative to the station, in world axes (east, north, up)."""
    header.frame_id = "world"
    return build.message(
        "geometry_msgs/msg/PointStamped", header=header, point=build.xyz("geometry_msgs/msg/Point", value.position_m)
    )


def _bearing(value: Any, header: Any, errors: Errors) -> Any:
    """Return a message with the unit vector to the pinger, in the sensor's frame."""
    level = math.cos(value.elevation_rad)
    way = (level * math.cos(value.azimuth_rad), level * math.sin(value.azimuth_rad), math.sin(value.elevation_rad))
    return build.message("geometry_msgs/msg/Vector3Stamped", header=header, vector=build.vector(way))


def _depth_pose(value: float, header: Any, errors: Errors, origin_m: Any) -> Any:
    covariance = independent(UNOBSERVED, UNOBSERVED, errors.variance("depth"), *[UNOBSERVED] * 3)
    pose = build.pose((0.0, 0.0, origin_m[2] - value), build.IDENTITY_XYZW)
    return build.message(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        header=header,
        pose=build.message("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
    )


def _heading(value: float, header: Any, errors: Errors, origin_m: Any) -> Any:
    """Return an Imu message that contains only the heading, as a yaw counter-clockwise from east (REP 103)."""
    unknown = np.array([UNKNOWN, *[0.0] * 8])
    return build.message(
        "sensor_msgs/msg/Imu",
        header=header,
        orientation=build.quaternion(about_z(0.5 * math.pi - value)),
        orientation_covariance=independent(UNOBSERVED, UNOBSERVED, errors.variance("heading")),
        angular_velocity_covariance=unknown,
        linear_acceleration_covariance=unknown,
    )


def _dvl_twist(value: Any, header: Any, errors: Errors, origin_m: Any) -> Any:
    _, beams = _dvl_beams(errors.mount)
    covariance = np.diag([UNOBSERVED] * 6)
    covariance[:3, :3] = _dvl_covariance(value, beams, errors).reshape(3, 3)
    if covariance[0, 0] < 0.0:
        return None  # too few beams
    twist = build.message("geometry_msgs/msg/Twist", linear=build.vector(DOWN * value.velocity_m_s))
    return build.message(
        "geometry_msgs/msg/TwistWithCovarianceStamped",
        header=header,
        twist=build.message("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance.ravel()),
    )


FILTER_INPUTS: dict[str, FilterInput] = {
    "depth": FilterInput(
        "pose", "geometry_msgs/msg/PoseWithCovarianceStamped", "depth as a height in odom; only z is measured",
        _depth_pose, "odom", takes_columns=True,
    ),
    "compass": FilterInput(
        "imu", "sensor_msgs/msg/Imu", "magnetic heading as a yaw, counter-clockwise from east; only yaw is measured",
        _heading, "base_link", takes_columns=True,
    ),
    "dvl": FilterInput(
        "twist", "geometry_msgs/msg/TwistWithCovarianceStamped", "velocity over the bed; no rate is measured",
        _dvl_twist,
    ),
    "ins": FilterInput(
        "odometry", "nav_msgs/msg/Odometry", "position, velocity and attitude of an INS; no rate is measured",
        ins_odometry, "odom",
    ),
}  # fmt: skip
"""Messages for filters, by kind of sensor, on the topic NAME/suffix."""

KINDS: dict[str, Kind] = {
    "imu": Kind("sensor_msgs/msg/Imu", _imu, takes_columns=True),
    "pressure": Kind(
        "sensor_msgs/msg/FluidPressure",
        _plain("sensor_msgs/msg/FluidPressure", "fluid_pressure", "pressure"),
        takes_columns=True,
    ),
    "temperature": Kind(
        "sensor_msgs/msg/Temperature",
        _plain("sensor_msgs/msg/Temperature", "temperature", "temperature"),
        takes_columns=True,
    ),
    "altitude": Kind("sensor_msgs/msg/Range", _range, even_invalid=True, takes_columns=True),
    "proximity": Kind("sensor_msgs/msg/Range", _range, even_invalid=True, takes_columns=True),
    "dvl": Kind("marine_acoustic_msgs/msg/Dvl", dvl_message, even_invalid=True),
    "adcp": Kind("marine_acoustic_msgs/msg/Dvl", _water_track, even_invalid=True),
    GPS: Kind("sensor_msgs/msg/NavSatFix", nav_sat_fix, even_invalid=True),
    "usbl": Kind("geometry_msgs/msg/PointStamped", _usbl),
    "bearing": Kind("geometry_msgs/msg/Vector3Stamped", _bearing),
    "depth": Kind("std_msgs/msg/Float64", _bare("std_msgs/msg/Float64", float), takes_columns=True),
    "compass": Kind("std_msgs/msg/Float64", _bare("std_msgs/msg/Float64", float), takes_columns=True),
    "gyrocompass": Kind("std_msgs/msg/Float64", _bare("std_msgs/msg/Float64", float), takes_columns=True),
    "ctd": Kind("std_msgs/msg/Float64MultiArray", _numbers),
    "contact": Kind("std_msgs/msg/Bool", _bare("std_msgs/msg/Bool", bool), takes_columns=True),
}
"""The message for each of uwsim's kinds of sensors; those of packages have their own.

Kinds without an entry describe the true motion, which is published on /odom.
"""
