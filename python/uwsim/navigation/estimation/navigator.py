"""Navigator: a vehicle's pose and velocity from its own instruments."""

from __future__ import annotations

import base64
import json
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.motion import Pose, Velocity
from uwsim.base.named import require_names
from uwsim.base.saved_state import checked
from uwsim.base.sealed import Attached
from uwsim.navigation.estimation.aids import (
    AIDS,
    COMPASSES,
    GAUGES,
    LEVEL,
    Surroundings,
    body_from_sensor,
    chosen_aids,
    north_rad,
)
from uwsim.navigation.estimation.budget import position_budget
from uwsim.navigation.estimation.errors import bias_model, limit, matrix_stds, white_std, whole_std
from uwsim.navigation.estimation.protocols import Instrumented, InstrumentLike, StreamLike
from uwsim.navigation.estimation.saved import HeldState, NavigatorState, Start

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

IMU = "the IMU's inertial samples"  # must differ from the aids' names, since one of them may be the same IMU
SILENCE_NS = 500_000_000  # motion is assumed to continue after this long without IMU samples
UNKNOWN_M = 1e4  # standard deviation of the position before the first fix
LEVEL_STD_RAD = 2e-3  # minimum assumed error of the initial roll and pitch
HELD_NS = 500_000_000  # interval between the readings of a dock
DOCK_STD_M, DOCK_STD_RAD, DOCK_STD_M_S = 0.1, 0.02, 0.05  # assumed: a surveyed dock, and how it lets go
# Expected standard deviation of the water's surface by waves where nothing is known, and in any case, since no water is
# still; of the tide, as on an open coast, and where no chart shows one; of the density of the water above, between a
# lake and the sea, and where one value holds for all depths
UNKNOWN_SEA_M, LEAST_SEA_M = 0.1, 0.001
UNKNOWN_TIDE_M, LEAST_TIDE_M = 1.0, 0.005
UNKNOWN_COLUMN, LEAST_COLUMN = 0.01, 0.0003
UNKNOWN_SOUND_M_S = (1440.0, 1540.0)  # of most waters (EOS-80): fresh at 8 deg C, a warm sea
COMPRESSIBILITY_1_PA = 4.7e-10  # of water within 8 %, from a cold lake to a warm sea (EOS-80), and of gravity 0.2e-10
YAW_STD_RAD = 0.1  # the initial heading has little weight, since its aid will measure it again


class Navigator(Attached):
    """An error-state Kalman filter on a vehicle's IMU, corrected by its DVL, depth, compass, USBL and GPS, if present.

    vehicle: provides named sensors; the first of each kind is used. start: the initial motion; by default, at rest at
    the position of the first fixes of its USBL or GPS. gravity_m_s2: the acceleration due to gravity. density_kg_m3,
    compressibility_1_pa: of the water at its surface, by which pressure becomes depth. wave_std_m: expected standard
    deviation of the water's surface by waves, a quarter of the significant wave height; the filter starts with it and
    adapts to the waves that the depth or pressure sensor then measures. tide_std_m: expected standard deviation of the
    still surface about z = 0, of an unknown phase: 0.7 of the tide's amplitude. column_std: expected standard deviation
    of the mean density of the water above the vehicle, relative to density_kg_m3. sound_m_s: the least and the largest
    speed of sound in the water, as expected, for a DVL that is set to one. The filter estimates both, as far as
    another reference observes the height. The filter's error models follow from the sensors' noise parameters. Raises
    ValueError for a vehicle without an IMU, or with none of a start, a USBL and a GPS.

    Readings are processed whenever `pose` and the other results are read; the estimate does not depend on how often
    that happens. See docs/guides/estimation.md.
    """

    _fixed_when = "the navigator is made"

    def __init__(
        self,
        vehicle: Instrumented,
        start: Start | None = None,
        *,
        gravity_m_s2: float = 9.80665,
        density_kg_m3: float = 1000.0,
        compressibility_1_pa: float = COMPRESSIBILITY_1_PA,
        wave_std_m: float = UNKNOWN_SEA_M,
        tide_std_m: float = UNKNOWN_TIDE_M,
        column_std: float = UNKNOWN_COLUMN,
        sound_m_s: tuple[float, float] = UNKNOWN_SOUND_M_S,
    ) -> None:
        sensors: Mapping[str, InstrumentLike] = vehicle.sensors
        imus = [sensor for sensor in sensors.values() if sensor.kind == "imu"]
        if not imus:
            raise ValueError(f"vehicle '{vehicle.name}': has no sensor of kind imu, which navigation needs")
        self._imu = imus[0]
        self._aids = chosen_aids(dict(sensors))
        self._silence_ns = max(SILENCE_NS, round(20e9 * self._imu.period_s))
        if start is None and not any(aid.kind in ("usbl", "gps") for aid in self._aids.values()):
            raise ValueError(f"vehicle '{vehicle.name}': has no USBL and no GPS, so navigation needs start=Start(...)")
        self._around = Surroundings(
            np.asarray(self._imu.spec.position_m),
            gravity_m_s2,
            density_kg_m3,
            compressibility_1_pa,
            max(wave_std_m, LEAST_SEA_M),
            max(tide_std_m, LEAST_TIDE_M),
            max(column_std, LEAST_COLUMN),
            sound_m_s,
        )
        self._body_from_imu = body_from_sensor(self._imu).as_matrix()
        self._matrices = matrix_stds(self._imu)
        self._filter = _core.NavigationFilter(
            imu_body_m=self._around.imu_body_m,
            gravity_m_s2=gravity_m_s2,
            period_s=self._imu.period_s,
            rate_std=white_std(self._imu, "angular_velocity"),
            force_std=white_std(self._imu, "linear_acceleration"),
            rate_bias=bias_model(self._imu, "angular_velocity"),
            force_bias=bias_model(self._imu, "linear_acceleration"),
            rate_limit=limit(self._imu, "angular_velocity"),
            force_limit=limit(self._imu, "linear_acceleration"),
            averaging_s=getattr(self._imu, "averaging_s", 0.0),
            body_from_imu=self._body_from_imu,
            **self._matrices,
        )
        self._indices = {
            name: AIDS[sensor.kind].add_to(self._filter, sensor, self._around) for name, sensor in self._aids.items()
        }
        self._dock = self._filter.add_dock(DOCK_STD_M, DOCK_STD_RAD, DOCK_STD_M_S)
        self._held: HeldState | None = None
        self._open: list[StreamLike] = []
        self._lock = threading.RLock()  # several threads may read a live simulator's estimate
        self.restart(start)

    def __repr__(self) -> str:
        east, north, up = self.pose.position_world_m.tolist()
        std_m = float(np.sqrt(np.trace(self.covariance[:3, :3])))
        aids = ", ".join(self._aids) or "no aids"
        return f"<Navigator by IMU, {aids}: at ({east:.2f}, {north:.2f}, {up:.2f}) m, std {std_m:.2g} m>"

    def restart(self, start: Start | None = None) -> None:
        """Restart now. start: defaults to the first fixes of the USBL or GPS."""
        with self._lock:
            self._restart(start)

    def _restart(self, start: Start | None) -> None:
        from scipy.spatial.transform import Rotation  # slow to import

        now_ns = self._imu.time_ns
        start = start or Start((0.0, 0.0, 0.0), UNKNOWN_M)
        tilt_std = max(whole_std(self._imu, "orientation"), LEVEL_STD_RAD)
        self._filter.start(
            time_ns=now_ns,
            position_world_m=start.position_world_m,
            orientation_xyzw=self._first_orientation().as_quat(),
            position_std_m=np.full(3, start.position_std_m),
            attitude_std_rad=np.array([tilt_std, tilt_std, YAW_STD_RAD]),
            velocity_world_m_s=np.asarray(start.velocity_world_m_s, float),
            velocity_std_m_s=start.velocity_std_m_s,
        )
        self._held = None
        if start.held_xyzw is not None:
            turn = Rotation.from_quat(start.held_xyzw)
            imu_world_m = start.position_world_m + turn.apply(self._around.imu_body_m)
            self._held = HeldState(next_ns=now_ns + HELD_NS, reading=[*imu_world_m.tolist(), *turn.as_quat().tolist()])
        # The current IMU sample starts the first interval.
        self._listen({**dict.fromkeys(self._aids, now_ns + 1), IMU: now_ns}, now_ns)

    def _listen(self, from_ns: Mapping[str, int], imu_ns: int) -> None:
        """Start collecting samples.

        from_ns: the first time stamp to collect from each sensor. imu_ns: the time up to which the filter has IMU
        samples.
        """
        self._close()
        self._imu_ns = imu_ns
        self._now_ns = -1
        self._from_ns = dict(from_ns)
        self._imu_stream = self._imu.stream(from_ns[IMU])
        self._streams: dict[str, StreamLike] = {
            name: sensor.stream(from_ns[name]) for name, sensor in self._aids.items()
        }
        self._open = [self._imu_stream, *self._streams.values()]

    def _first_orientation(self) -> Rotation:
        """Return the orientation from the IMU's roll and pitch plus, if there is a compass, its heading."""
        from scipy.spatial.transform import Rotation  # slow to import

        value = self._imu.read()
        world_from_body = Rotation.from_quat(value.orientation_xyzw) * body_from_sensor(self._imu).inv()
        for compass in self._aids.values():
            if compass.kind in COMPASSES and compass.on:
                ahead = world_from_body.apply(body_from_sensor(compass).apply([1.0, 0.0, 0.0]))
                turn = north_rad(compass) - compass.read() - math.atan2(ahead[1], ahead[0])
                return Rotation.from_rotvec([0.0, 0.0, turn]) * world_from_body
        return world_from_body

    def _close(self) -> None:
        for stream in self._open:
            stream.close()

    def become(self, make: Callable[[], Navigator]) -> None:
        """Continue as another Navigator of the same vehicle, from scratch: `make` creates it, for this use only."""
        with self._lock:
            self._close()
            self.__dict__ |= {name: value for name, value in vars(make()).items() if name != "_lock"}

    def release(self) -> None:
        """End the hold by a dock (Start.held_xyzw): from now on, the vehicle is free."""
        with self._lock:
            self._current()
            self._held = None

    def update(self) -> None:
        """Process all samples that have arrived. This also happens whenever the estimate is read."""
        with self._lock:
            self._current()

    def _current(self) -> _core.NavigationFilter:
        """Return the filter after processing all samples that have arrived."""
        now_ns = self._imu.time_ns
        if now_ns != self._now_ns:
            self._now_ns = now_ns
            self._process_imu(now_ns)
            for name, stream in self._streams.items():
                self._process_aid(name, stream)
            if self._held is not None:
                self._held = self._read_dock(self._held, now_ns)
            self._filter.catch_up()
        return self._filter

    def _read_dock(self, held: HeldState, now_ns: int) -> HeldState:
        """Add the dock's readings until now, at fixed times."""
        stamps_ns = np.arange(held.next_ns, now_ns + 1, HELD_NS, dtype=np.uint64)
        self._filter.add_readings(self._dock, stamps_ns, stamps_ns, np.tile(held.reading, (len(stamps_ns), 1)))
        return held.model_copy(update={"next_ns": held.next_ns + HELD_NS * len(stamps_ns)})

    def _process_aid(self, name: str, stream: StreamLike) -> None:
        samples, sensor = stream.take(), self._aids[name]
        if not len(samples.stamps_ns):
            return
        self._from_ns[name] = int(samples.stamps_ns[-1]) + 1
        if sensor.on:
            useful, readings = AIDS[sensor.kind].readings(sensor, samples, self._around)
            columns = samples.stamps_ns, samples.arrivals_ns, readings
            kept = columns if useful.all() else tuple(column[useful] for column in columns)
            self._filter.add_readings(self._indices[name], *kept)

    def _process_imu(self, now_ns: int) -> None:
        samples = self._imu_stream.take()
        if self._imu.on and len(samples.stamps_ns):
            turn = self._body_from_imu.T
            rates_and_forces = np.empty((len(samples.stamps_ns), 6))
            rates_and_forces[:, :3] = samples.readings[:, :3] @ turn
            rates_and_forces[:, 3:] = samples.readings[:, 3:6] @ turn
            self._filter.add_imu(samples.stamps_ns, rates_and_forces)
            newest_ns = int(samples.stamps_ns[-1])
            if newest_ns - self._imu_ns > self._silence_ns:  # otherwise there is no gap among them
                stamps_ns = np.concatenate([[self._imu_ns], samples.stamps_ns.astype(np.int64)])
                for gap in np.flatnonzero(np.diff(stamps_ns) > self._silence_ns):
                    self._step_through_gap(int(stamps_ns[gap]), int(stamps_ns[gap + 1]))
            self._imu_ns = newest_ns
            self._from_ns[IMU] = self._imu_ns + 1
        self._imu_ns = self._step_through_gap(self._imu_ns, now_ns - round(self._imu.latency_s * 1e9))

    def _step_through_gap(self, before_ns: int, after_ns: int) -> int:
        """Step the filter through a gap in the IMU samples, at fixed times between two stamps; return the last time."""
        while before_ns + self._silence_ns < after_ns:
            before_ns += self._silence_ns
            self._filter.add_silence(before_ns)
        return before_ns

    @property
    def time_s(self) -> float:
        """The time of the estimate in seconds: that of the latest IMU sample."""
        with self._lock:
            return self._current().time_ns * 1e-9

    @property
    def pose(self) -> Pose:
        """The estimated pose."""
        with self._lock:
            now = self._current()
            return Pose(now.position_world_m, now.orientation_xyzw, now.world_from_body)

    @property
    def velocity(self) -> Velocity:
        """The estimated velocity over ground."""
        with self._lock:
            now = self._current()
            return Velocity(now.linear_body_m_s, now.angular_body_rad_s)

    @property
    def rate_std_rad_s(self) -> float:
        """Standard deviation of the white noise in the angular velocity, rad/s; its bias is in `covariance`."""
        return white_std(self._imu, "angular_velocity")

    @property
    def covariance(self) -> Floats:
        """Covariance (15, 15) of position [m] and velocity [m/s] in world axes, attitude [rad], and the IMU biases.

        Attitude and the biases of gyroscope [rad/s] and accelerometer [m/s2] are in body axes. Position and velocity
        refer to the IMU's centre.
        """
        with self._lock:
            return np.asarray(self._current().covariance[:15, :15])

    @property
    def numbers(self) -> Floats:
        """Time, motion and covariance side by side, (248,): see `_core.NavigationFilter.numbers`."""
        with self._lock:
            return self._current().numbers

    @property
    def position_std_m(self) -> Floats:
        """Standard deviations of the position along east, north and up, (3,)."""
        return np.sqrt(np.diagonal(self.covariance)[:3])

    @property
    def budget(self) -> dict[str, Floats]:
        """Standard deviations (3,) of the position along east, north and up [m] by their source, as `dvl.scale`.

        Their squares add up to those of position_std_m; see uwsim.navigation.estimation.budget.
        """
        with self._lock:
            terms = {"imu.gyroscope": slice(9, 12), "imu.accelerometer": slice(12, 15)}
            for name in (name for name, stds in self._matrices.items() if any(stds)):
                terms[f"imu.{name}"] = slice(before := 9 * len(terms) - 3, before + 9)
            for name, index in self._indices.items():
                first = self._filter.first_bias(index)
                for term, number in AIDS[self._aids[name].kind].terms(self._aids[name], self._around).items():
                    terms[f"{name}.{term}"] = slice(first, first + number)
                    first += number
            return position_budget(np.asarray(self._current().covariance), terms)

    @property
    def surface_m(self) -> tuple[float, float]:
        """The height of the still surface above z = 0 and its standard deviation [m]; 0, 0 without a depth gauge."""
        with self._lock:
            now = self._current()
            for name, index in self._indices.items():
                if self._aids[name].kind in GAUGES:
                    level = now.first_bias(index) + LEVEL
                    return float(now.aid_biases[level - 15]), math.sqrt(now.covariance[level, level])
            return 0.0, 0.0

    @property
    def depth_m(self) -> float:
        """The depth of the vehicle's origin below the still surface [m]."""
        with self._lock:
            return self.surface_m[0] - float(self.pose.position_world_m[2])

    @property
    def imu_biases(self) -> tuple[Floats, Floats]:
        """The estimated biases of the gyroscope [rad/s] and the accelerometer [m/s2] in body axes, (3,) each."""
        with self._lock:
            now = self._current()
            return now.rate_bias_rad_s, now.force_bias_m_s2

    @property
    def counts(self) -> dict[str, tuple[int, int]]:
        """The number of scalar readings used and the number rejected as outliers, by name of the aiding sensor."""
        with self._lock:
            now = self._current()
            return {name: now.counts(index) for name, index in self._indices.items()}

    @property
    def too_late(self) -> int:
        """The number of readings that arrived too late to be used, 4 s after their measurement."""
        with self._lock:
            return self._current().too_late

    def save(self, use: str = "steering") -> str:
        """Return the state for use with `restore`. use: see NavigatorState."""
        with self._lock:
            filter_ = base64.b64encode(self._current().save()).decode()
            figures = {
                "silence_ns": self._silence_ns,
                "gravity_m_s2": self._around.gravity_m_s2,
                "density_kg_m3": self._around.density_kg_m3,
                "compressibility_1_pa": self._around.compressibility_1_pa,
            }
            times = {"use": use, "imu_ns": self._imu_ns, "from_ns": self._from_ns}
            held = {"held": None if self._held is None else self._held.model_dump()}
            return json.dumps(
                {"version": self._filter.save_version, "filter": filter_, **times, "figures": figures, **held}
            )

    def restore(self, saved: str) -> None:
        """Continue from a saved state of the same vehicle at the same time. Raises ValueError."""
        state = checked(NavigatorState, saved)
        if state.version != (version := self._filter.save_version):
            raise ValueError(f"state.version = {state.version}: must be {version}: another version of uwsim saved it")
        require_names("from_ns", state.from_ns, self._from_ns)
        with self._lock:
            self._filter.restore(state.filter)
            self._held = state.held
            self._silence_ns = state.figures.silence_ns
            self._around = replace(self._around, **state.figures.model_dump(exclude={"silence_ns"}))
            self._listen(state.from_ns, state.imu_ns)
