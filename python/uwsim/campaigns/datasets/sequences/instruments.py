"""The instruments of a sequence: each writes its samples, pictures or pings to its folder and to the bag.

They are read in order of simulated time, so the same scenario, seed and mission give the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.npz import npz_bytes
from uwsim.campaigns.datasets.sequences.calibration import (
    body_from_optical,
    camera_calibration,
    imu_noise,
    mounted,
    require_calibrated,
)
from uwsim.campaigns.datasets.sequences.euroc import Files, Rows, write_sensor
from uwsim.campaigns.datasets.sequences.tum import Tum
from uwsim.channels import Channel, Table
from uwsim.channels.delivery.pictures import RATE_HZ
from uwsim.channels.families.cameras import compressed_image, info_message
from uwsim.channels.families.instruments import sample_messages
from uwsim.channels.source import Source
from uwsim.instruments.cameras import Camera
from uwsim.instruments.cameras.image_file import encode_png
from uwsim.instruments.sensors import Sensor
from uwsim.instruments.sonars.imaging import SideScan
from uwsim.instruments.sonars.mounted import ImagingSonar
from uwsim.scenario.spec.sensor_kind import sensor_kind
from uwsim.simulator.simulator import Simulator

Say = Callable[[Channel, Any, int], None]
"""Writes a message of a channel, with its time [ns], to the bag."""
Description = tuple[str, str, NDArray[np.float64], Mapping[str, Any]]
"""The content of sensor.yaml: kind, comment, T_BS, and the keys of that kind."""
PNG_FORMAT = "rgb8; png compressed bgr8"
TRUTH_HZ = 200.0
LOWEST_DB, STEP_DB = -100.0, 0.01
"""Sonar levels are stored in 16 bits: level = LOWEST_DB + STEP_DB * value; 0: no level."""
IMU_COLUMNS = (*(f"w_RS_S_{axis} [rad s^-1]" for axis in "xyz"), *(f"a_RS_S_{axis} [m s^-2]" for axis in "xyz"))
TRUTH_COLUMNS = (
    *(f"p_RS_R_{axis} [m]" for axis in "xyz"),
    *(f"q_RS_{axis} []" for axis in "wxyz"),
    *(f"v_RS_R_{axis} [m s^-1]" for axis in "xyz"),
)


class Instrument:
    """One instrument: its files in a folder, and its messages in the bag. rate_hz: how often `read` is called."""

    rate_hz = RATE_HZ

    def __init__(self, folder: Path, source: Source, say: Say, files: Rows | Files) -> None:
        self.folder, self._source, self._say, self._files = folder, source, say, files

    @property
    def count(self) -> int:
        """The number of samples, pictures or pings written."""
        return self._files.count

    def read(self, sim: Simulator) -> None:
        """Write the new samples."""
        raise NotImplementedError

    def close(self) -> None:
        """Finish the files. Raises OSError."""
        self._files.close()
        if (described := self._described()) is not None:
            write_sensor(self.folder, *described)

    def _described(self) -> Description | None:
        """Return what sensor.yaml states; None for an instrument that has written nothing."""
        raise NotImplementedError


def _named(table: Table, name: str) -> Channel:
    return next(channel for channel in table.channels if channel.name == name)


class Sampled(Instrument):
    """A sensor with numeric samples: all those that are not lost, with the times of their measurement."""

    def __init__(self, folder: Path, source: Source, sim: Simulator, name: str, say: Say, channel: Channel | None):
        self.name, self._sim, self._channel = name, sim, channel
        self.sensor: Sensor[Any] = source.of(sim).sensors[name]
        self.mount = source.model(sim).sensors[name]
        self._stream, self._message = self.sensor.stream(), sample_messages(source, sim, name)
        fields = dict(sensor_kind(self.sensor.kind).fields)
        self._width = 6 if self.sensor.kind == "imu" else sum(width for width, _ in fields.values())
        columns = IMU_COLUMNS if self.sensor.kind == "imu" else (*_columns(fields), "valid []")
        self._rows = Rows(folder, columns)
        super().__init__(folder, source, say, self._rows)

    def _described(self) -> Description:
        is_imu = self.sensor.kind == "imu"
        more = imu_noise(self.mount, self.sensor) if is_imu else {"rate_hz": 1.0 / self.sensor.period_s}
        parameters = {key: [float(value) for value in values] for key, values in self.mount.parameters.items()}
        more |= {"parameters": parameters} if parameters and not is_imu else {}
        pose = mounted(self.mount.position_m, self.mount.yaw_pitch_roll_deg)
        return self.sensor.kind, f"{self.name}: {self.sensor.meaning}", pose, more

    def read(self, sim: Simulator) -> None:
        """See Instrument."""
        rows = self._stream.take()
        for k, sample in enumerate(self.sensor.samples_of(rows)):
            values = rows.readings[k, : self._width].tolist()
            if self.sensor.kind != "imu":
                self._rows.add(sample.stamp_ns, *values, str(int(sample.valid)))
            elif sample.valid:
                self._rows.add(sample.stamp_ns, *values)
            if self._channel is not None:
                message = self._message(sim, sample)
                if message is not None:
                    self._say(self._channel, message, int(rows.arrivals_ns[k]))

    def close(self) -> None:
        """See Instrument."""
        self.read(self._sim)
        super().close()


class Seen(Instrument):
    """A camera: its pictures as PNG, the same bytes in the folder and in the bag."""

    def __init__(self, folder: Path, source: Source, table: Table, sim: Simulator, name: str, say: Say):
        self.camera: Camera = source.of(sim).cameras[name]
        require_calibrated(name, self.camera)
        self._pictures = Files(folder, ".png")
        super().__init__(folder, source, say, self._pictures)
        self.name, self._key = name, source.prefix + name
        self._taken, self._frame = table.pictures, source.frame(f"{name}_optical")
        self.topic = f"{source.prefix}camera/{name}/image_raw/compressed"
        self._image, self._info = (
            _named(table, topic) for topic in (self.topic, f"{source.prefix}camera/{name}/camera_info")
        )
        self.body_from_optical = body_from_optical(self.camera.world_from_camera, source.of(sim).pose.world_from_body)
        self._aim_rad = self.camera.aim_rad
        self.info: Any = None

    def read(self, sim: Simulator) -> None:
        """See Instrument. Raises ValueError if the camera has turned, as its calibration then no longer holds."""
        if self.camera.aim_rad != self._aim_rad:
            raise ValueError(f"camera {self.name}: was turned by the mission, so that it has no single T_BS")
        picture = self._taken.read(sim, self._key, self.camera)
        if picture is None or picture.frame.time_ns <= self._pictures.last_ns:  # the first one is read twice
            return
        content = encode_png(picture.frame.rgb)
        self._pictures.add(picture.frame.time_ns, content)
        stamp_ns, self.info = picture.frame.time_ns, picture.frame.info
        self._say(self._image, compressed_image(content, stamp_ns, self._frame, PNG_FORMAT), stamp_ns)
        self._say(self._info, info_message(picture, self._frame, is_sent=False), stamp_ns)

    def _described(self) -> Description | None:
        if self.info is None:
            return None
        return "camera", self.name, self.body_from_optical, camera_calibration(self.info, self.rate_hz)


class Pinged(Instrument):
    """A multibeam: each ping as .npz, and as LaserScan and PointCloud2 in the bag."""

    def __init__(self, folder: Path, source: Source, table: Table, sim: Simulator, say: Say):
        self._archives = Files(folder, ".npz")
        super().__init__(folder, source, say, self._archives)
        self._pings = table.pings[source.name]
        self.rate_hz = self._pings.rate_hz
        self._channels = [_named(table, source.topic(name)) for name in ("scan", "points")]
        vehicle = source.of(sim)
        self._body_from_sonar = np.linalg.inv(vehicle.pose.world_from_body) @ vehicle.sonar.ping().world_from_sonar

    def read(self, sim: Simulator) -> None:
        """See Instrument."""
        taken = self._pings.newest(sim)
        ping = taken.ping
        if ping.time_ns <= self._archives.last_ns:
            return
        content = npz_bytes(
            ranges_m=ping.ranges_m, angles_rad=ping.angles_rad, valid=ping.valid, intensity_db=ping.intensity_db,
            points_sonar_m=ping.points_sonar_m,
            body_from_sonar=np.linalg.inv(taken.odom_from_body) @ taken.odom_from_sonar,
        )  # fmt: skip
        self._archives.add(ping.time_ns, content)
        for channel in self._channels:
            if (message := channel.read(sim)) is not None:
                self._say(channel, message, ping.time_ns)

    def _described(self) -> Description:
        model = self._pings.model
        more = {
            "rate_hz": self.rate_hz, "beams": model.beams, "field_of_view_rad": model.field_of_view_rad,
            "range_max_m": model.range_max_m, "frequency_hz": model.frequency_hz,
        }  # fmt: skip
        comment = f"{model.name}; the head turns: body_from_sonar of each ping, T_BS is that of the first"
        return "multibeam", comment, self._body_from_sonar, more


class Imaged(Instrument):
    """An imaging sonar: 16-bit levels, one picture per ping; for a side-scan, one picture with a row per ping."""

    def __init__(self, folder: Path, source: Source, table: Table, sim: Simulator, name: str, say: Say):
        self.name = name
        self._sonar: ImagingSonar = source.of(sim).imaging_sonars[name]
        self._channel = _named(table, f"{source.topic(name)}/image")
        assert self._channel.rate_hz is not None
        self.rate_hz = self._channel.rate_hz
        self._is_waterfall = isinstance(self._sonar.model, SideScan)
        self._body_from_sonar = np.linalg.inv(source.of(sim).pose.world_from_body) @ self._sonar.world_from_sonar
        self._geometry: dict[str, Any] = {}
        self._lines: list[NDArray[np.uint16]] = []
        super().__init__(folder, source, say, Rows(folder, ["row"]) if self._is_waterfall else Files(folder, ".png"))
        self._last_ns = -1

    def read(self, sim: Simulator) -> None:
        """See Instrument."""
        message = self._channel.read(sim)
        if message is None:
            return
        stamp_ns = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        if stamp_ns <= self._last_ns:  # the first one is read twice
            return
        self._last_ns = stamp_ns
        levels = sixteen_bits(message.image.data.view("<f4").reshape(-1, message.image.beam_count))
        if isinstance(self._files, Files):
            self._files.add(stamp_ns, encode_png(levels))
        else:
            self._files.add(stamp_ns, str(len(self._lines)))
            self._lines.append(np.concatenate([levels[::-1, 1], levels[:, 0]]))
        bearings = [float(np.arctan2(-beam.y, beam.z)) for beam in message.beam_directions]
        ranges_m = {"first": float(message.ranges[0]), "last": float(message.ranges[-1]), "count": len(message.ranges)}
        self._geometry = {"bearings_rad": bearings, "ranges_m": ranges_m}
        self._say(self._channel, message, stamp_ns)

    def close(self) -> None:
        """See Instrument."""
        super().close()
        if self._lines:
            (self.folder / "waterfall.png").write_bytes(encode_png(np.stack(self._lines)))

    def _described(self) -> Description:
        model: Any = self._sonar.model
        layout = "a row for each ping; columns: port from the farthest, then starboard from the nearest"
        layout = (
            layout if self._is_waterfall else "rows: ranges_m, evenly spaced; columns: bearings_rad, positive to port"
        )
        more = {
            "rate_hz": self.rate_hz, "frequency_hz": model.frequency_hz, "range_max_m": model.range_max_m,
            "level_db": {"offset": LOWEST_DB, "per_unit": STEP_DB}, "layout": layout, **self._geometry,
        }  # fmt: skip
        return type(model).__name__, f"{self.name}: levels re 1 uPa", self._body_from_sonar, more


class Truth(Instrument):
    """The vehicle's true pose and velocity, written as EuRoC ground truth, as a TUM trajectory, and to the bag."""

    rate_hz = TRUTH_HZ

    def __init__(self, folder: Path, tum: Path, source: Source, table: Table, say: Say):
        self._rows = Rows(folder, TRUTH_COLUMNS)
        super().__init__(folder, source, say, self._rows)
        self._tum = Tum(tum)
        self._channel = _named(table, source.topic("ground_truth/odom"))

    def read(self, sim: Simulator) -> None:
        """See Instrument."""
        rov = self._source.of(sim)
        position, (x, y, z, w) = rov.pose.position_world_m.tolist(), rov.pose.orientation_xyzw.tolist()
        velocity = (rov.pose.world_from_body[:3, :3] @ rov.velocity.linear_body_m_s).tolist()
        self._rows.add(sim.time_ns, *position, w, x, y, z, *velocity)
        self._tum.add(sim.time_ns, position, (x, y, z, w))
        self._say(self._channel, self._channel.read(sim), sim.time_ns)

    def close(self) -> None:
        """See Instrument."""
        super().close()
        self._tum.close()

    def _described(self) -> Description:
        comment = "true pose and velocity of the body frame in the world: x east, y north, z up"
        return "ground-truth", comment, np.eye(4), {"rate_hz": self.rate_hz}


def sixteen_bits(level_db: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return the 16-bit values of levels [dB], LOWEST_DB + STEP_DB * value; 0 where there is no level."""
    with np.errstate(invalid="ignore"):
        values = np.rint((level_db - LOWEST_DB) / STEP_DB)
    return np.where(np.isfinite(values), np.clip(values, 1, 65535), 0).astype(np.uint16)


def _columns(fields: dict[str, tuple[int, str]]) -> list[str]:
    names = []
    for name, (width, unit) in fields.items():
        parts = [""] if width == 1 else [f"_{axis}" for axis in ("xyz" if width == 3 else range(width))]
        names += [f"{name}{part} [{unit}]" for part in parts]
    return names
