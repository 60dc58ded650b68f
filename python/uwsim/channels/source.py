"""A vehicle as a source of channels, with the names of its topics and frames and the origin of its odometry."""

from __future__ import annotations

from dataclasses import dataclass

from uwsim.base.arrays import Floats
from uwsim.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class Source:
    """A vehicle. entry: its initial settings. prefix: the prefix of its topics ("NAME/", or "" for a single vehicle).

    Frames (REP 105): world -> map -> odom -> base_footprint -> base_link -> base_scan. map is fixed in the world;
    origin_m (3,) is the world's origin in map. odom coincides with map. base_footprint and base_link are the body
    frame; base_scan turns with the sonar's head. frame_prefix: prefix of the names of its frames.
    """

    entry: VehicleEntry
    prefix: str
    origin_m: Floats
    frame_prefix: str

    @property
    def name(self) -> str:
        """The vehicle's name."""
        return self.entry.name

    @classmethod
    def all_of(cls, scenario: Scenario, origin_m: Floats, frame_prefix: str = "") -> list[Source]:
        """Return the sources of a scenario's vehicles."""
        alone = len(scenario.vehicles) == 1
        prefixes = ["" if alone else f"{entry.name}/" for entry in scenario.vehicles]
        return [
            cls(entry, prefix, origin_m, frame_prefix + prefix)
            for entry, prefix in zip(scenario.vehicles, prefixes, strict=True)
        ]

    def of(self, sim: Simulator) -> Vehicle:
        """Return the simulated vehicle."""
        return sim.vehicles[self.entry.name]

    def model(self, sim: Simulator) -> VehicleModel:
        """Return the vehicle's model with its current parameters."""
        return self.now(sim).model

    def command_timeout_s(self, sim: Simulator) -> float:
        """Return the time after which a silent publisher's commands expire, or 0 if they never do."""
        return self.now(sim).command_timeout_s

    def now(self, sim: Simulator) -> VehicleEntry:
        """Return the vehicle's settings with its current parameters."""
        name = self.name
        for entry in sim.parameters.scenario.vehicles:  # asked for many messages; a generator takes twice as long
            if entry.name == name:
                return entry
        raise KeyError(name)

    def topic(self, name: str) -> str:
        """Return the full name of a topic or service."""
        return self.prefix + name

    def frame(self, name: str) -> str:
        """Return the full name of a frame."""
        return self.frame_prefix + name

    def position_odom_m(self, sim: Simulator) -> Floats:
        """Return the vehicle's position in odom, (3,)."""
        return self.of(sim).pose.position_world_m + self.origin_m

    @property
    def scan_mount_m(self) -> tuple[float, float, float]:
        """The position of the sonar head on the body."""
        mount = self.entry.model.sonar
        assert mount is not None
        return mount.position_m

    @property
    def has_sonar(self) -> bool:
        """Whether the vehicle carries a multibeam."""
        return self.entry.model.sonar is not None
