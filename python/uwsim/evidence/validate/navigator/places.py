"""Places in which navigation is flown: what an operator knows of each is less than what acts there.

Tides and fresh water change the weight of the water above a depth gauge, and the speed of sound by which a DVL makes
velocities of its shifts; waves move gauge and vehicle; near the pole, the field that a compass points along is a few
microteslas, and a gyrocompass errs by the secant of the latitude; a ship takes the origin of the fixes with it, and
sends with them where its satellite receiver has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from uwsim.scenario import Scenario, VehicleModel, load_vehicle
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.simulator.simulator import Simulator

WITH_DVL = (
    "bluerov2_heavy", "bluerov2_heavy_cfd", "bluerov2_heavy_outfit", "bluerov2_tank", "bluerov2_wu", "lauv", "remus100",
    "rov",
)  # fmt: skip
WITH_GAUGE = (
    *WITH_DVL, "bluerov2_heavy_alpha5", "bluerov2_heavy_gripper", "paper", "paper_buoyant", "slocum",
)  # fmt: skip
SET_SOUND = {"dvl": {"sound_speed_m_s": (1500.0,)}}
AS_MOUNTED = {
    "dvl": {"scale": Noise(turn_on_std=0.003), "misalignment": Noise(turn_on_std=0.01)},
    "usbl": {"scale": Noise(turn_on_std=0.003), "bearing": Noise(std=0.01, turn_on_std=0.01)},
}
"""Assumed: a DVL of 0.3 % (Teledyne RDI: 0.2 to 0.6 %) and a USBL of 0.3 %, within 0.6 deg, before a calibration."""
ON_A_SHIP = {"usbl": {"station": Noise(std=0.05, turn_on_std=0.3), "bearing": Noise(std=0.005, turn_on_std=0.002)}}
"""Assumed: a receiver with differential corrections, and an attitude within 0.1 deg."""
CALIBRATED, AS_SOLD = (
    {
        "imu": {
            "gyro_scale": (size, -size, size),
            "accelerometer_scale": (-size, size, -size),
            "gyro_misalignment_rad": (angle_rad, angle_rad, -angle_rad, angle_rad, -angle_rad, -angle_rad),
        }
    }
    for size, angle_rad in ((0.003, 0.002), (0.01, 0.01))
)
"""Assumed: an IMU of 0.3 % and 2 mrad, as after a calibration, and one of 1 % and 10 mrad, as sold."""
POLAR = {"compass": {"field_ut": (55.0,), "inclination_deg": (83.0,)}}
"""Assumed, of the order of the earth's field at 80 degrees north, 20 degrees east."""
BY_GYRO = {
    "gyrocompass": SensorMount(
        kind="gyrocompass",
        rate_hz=10.0,
        noise=Noise(std=0.0005, turn_on_std=0.00175),
        parameters={"latitude_deg": (80.0,)},
    )
}
"""0.1 deg times the secant of the latitude, as makers of optical ones state."""


@dataclass(frozen=True)
class Place:
    """A bay, flown by a vehicle that starts at depth_m, 15 m above the bed.

    tide_m: amplitude of the M2 tide, of which each vehicle meets another phase. levels: depths [m] and salinities
    [psu]. surface: of the scenario's water. settings: parameters and errors of channels, by sensor. lost: sensors
    that are off in the second half of a flight. ship: whether a boat carries the station, which drifts with a current.
    added: more sensors. vehicles: those that fly.
    """

    depth_m: float
    tide_m: float = 0.0
    levels: tuple[tuple[float, float], ...] = ()
    surface: Mapping[str, Any] = field(default_factory=lambda: {"kind": "still"})
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    lost: tuple[str, ...] = ()
    ship: bool = False
    added: Mapping[str, SensorMount] = field(default_factory=dict)
    vehicles: tuple[str, ...] = WITH_DVL

    @property
    def start_world_m(self) -> tuple[float, float, float]:
        """Where a flight starts."""
        return (0.0, 0.0, -self.depth_m)

    def scenario(self, model: str, phase_deg: float = 0.0) -> Scenario:
        """Return a bay with this water, and a neutrally buoyant vehicle `rov`."""
        water: dict[str, Any] = {"salinity_psu": 35, "surface": dict(self.surface)}
        if self.levels:
            levels = [{"depth_m": z, "temperature_deg_c": 10, "salinity_psu": s} for z, s in self.levels]
            water["profile"] = {"kind": "table", "levels": levels}
            del water["salinity_psu"]
        if self.tide_m:
            constituent = {"constituent": "M2", "amplitude_m": self.tide_m, "phase_deg": phase_deg}
            water["tide"] = {"constituents": [constituent]}
        start = {"position_m": list(self.start_world_m)}
        vehicles: list[dict[str, Any]] = [
            {"name": "rov", "model": self.model(model), "trim": {"net_buoyancy_n": 0.0}, "start": start}
        ]
        station: dict[str, Any] = {"position_m": [30.0, 20.0, -5.0]}
        if self.ship:
            water["current_world_m_s"] = [0.2, -0.1, 0.0]
            station = {"carrier": "ship", "position_m": [-0.5, 0.0, -0.5]}
            vehicles.append({"name": "ship", "model": "otter", "start": {"position_m": [30.0, 20.0, 0.0]}})
        terrain = {"source": "noise", "size_m": [400, 400], "spacing_m": 10, "bed_depth_m": self.depth_m + 15}
        bay = {"name": "bay", "terrain": terrain, "water": water, "station": station, "vehicles": vehicles}
        return Scenario.model_validate(bay, context={"folder": assets_folder() / "scenarios"})

    def model(self, name: str) -> VehicleModel:
        """Return a packaged vehicle with the settings of those of its sensors that have any."""
        model = load_vehicle(name)
        mounts = {**model.sensors, **self.added}
        for sensor in mounts.keys() & self.settings.keys():
            mount, own = mounts[sensor], self.settings[sensor]
            channels = {key: value for key, value in own.items() if isinstance(value, Noise)}
            parameters = {key: value for key, value in own.items() if key not in channels}
            changes = {"channels": {**mount.channels, **channels}, "parameters": {**mount.parameters, **parameters}}
            mounts[sensor] = mount.model_copy(update=changes)
        return model.model_copy(update={"sensors": mounts})

    def simulators(self) -> list[Simulator]:
        """Return a simulator for each of the vehicles."""
        phases_deg = [360.0 * k / len(self.vehicles) for k in range(len(self.vehicles))]
        return [Simulator(self.scenario(*each)) for each in zip(self.vehicles, phases_deg, strict=True)]


STILL = "still water"
LENS = ((0.0, 5.0), (10.0, 5.0), (12.0, 35.0))
ESTUARY = ((0.0, 12.0), (8.0, 25.0), (20.0, 32.0))
PLACES = {
    STILL: Place(3.0),
    "Airy waves of 0.1 m, 5 s": Place(3.0, surface={"kind": "airy", "amplitude_m": 0.1, "period_s": 5.0}),
    "Airy waves of 0.25 m, 5 s": Place(3.0, surface={"kind": "airy", "amplitude_m": 0.25, "period_s": 5.0}),
    "a sea of 0.5 m, 5 s": Place(3.0, surface={"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 5.0}),
    "a tide of 1.5 m": Place(10.0, tide_m=1.5, vehicles=WITH_GAUGE),
    "an estuary, a tide of 4 m, the DVL set to 1500 m/s": Place(
        10.0, tide_m=4.0, levels=ESTUARY, settings=SET_SOUND, vehicles=WITH_GAUGE
    ),
    "a fjord below a fresh lens, the DVL set to 1500 m/s": Place(
        50.0, levels=LENS, settings=SET_SOUND, vehicles=WITH_GAUGE
    ),
    "the sea, 985 m deep": Place(985.0, vehicles=WITH_GAUGE),
    "DVL and USBL as mounted": Place(20.0, settings=AS_MOUNTED),
    "a ship's USBL": Place(20.0, settings=ON_A_SHIP, ship=True),
    "a keel's shade, half of the time without DVL": Place(10.0, lost=("dvl",)),
    "the second half without DVL and USBL": Place(20.0, lost=("dvl", "usbl"), vehicles=WITH_GAUGE),
    "the same, an IMU of 0.3 %": Place(20.0, settings=CALIBRATED, lost=("dvl", "usbl")),
    "the same, an IMU of 1 %": Place(20.0, settings=AS_SOLD, lost=("dvl", "usbl")),
    "80 degrees north, by compass": Place(20.0, settings=POLAR),
    "80 degrees north, by gyrocompass": Place(20.0, settings=POLAR, added=BY_GYRO),
}
