"""A vehicle whose thrusters and servos a system that speaks IMC commands, and whose motion or instruments it gets."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim.bridges.aboard.aboard import Aboard
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.imc.announcer import Announcer
from uwsim.bridges.imc.link import Identity, ImcLink, logger
from uwsim.bridges.imc.readings import MULTIBEAM, Instruments, Place, servos, simulated_state
from uwsim.bridges.imc.wire import Message, Sent
from uwsim.bridges.rare_log import RareLog
from uwsim.channels import Channel
from uwsim.channels.channel import ended_by
from uwsim.channels.delivery.feed import Reading
from uwsim.live import LiveSimulator
from uwsim.scenario import VehicleModel
from uwsim.simulator.simulator import Simulator

SIMULATOR, MOTOR, SONAR = "uwsim", "motor", "sonar"
"""Labels of entities."""
DRIVER = "IMC"
"""The name of the source that steers, in helms and refusals."""
RPM_MAX = 32767


@dataclass(frozen=True)
class Settings:
    """The settings of a vehicle. rate_hz: of its publications [Hz]. system: its number, or None for its peer's.

    by_instruments: whether it publishes its instruments and its estimate instead of SimulatedState. full_rpm: the
    revolutions of its first thruster at full command [1/min]. listen_port: for datagrams.
    """

    rate_hz: float = 20.0
    by_instruments: bool = False
    system: int | None = None
    full_rpm: float = 2500.0
    listen_port: int = 6001


class ImcVehicle:
    """Publishes a vehicle's motion or instruments, and commands its thrusters and fins as its peer asks.

    Commands end like a topic's when the peer falls silent, and lose the helm to a pilot. Use it as a context. Raises
    ValueError for a vehicle without thrusters.
    """

    def __init__(
        self,
        live: LiveSimulator,
        aboard: Aboard,
        model: VehicleModel,
        address: Endpoint,
        place: Place,
        settings: Settings,
    ) -> None:
        self._live, self._place, self._settings = live, place, settings
        self.vehicle, self._steering = aboard.source.name, aboard.steering
        if not model.thrusters:
            raise ValueError(f"imc: vehicle '{self.vehicle}': has no thrusters that could be commanded")
        self._thrusters, fins = list(model.thrusters), servos(model)
        self._fins = {servo.number: (name, servo) for name, servo in fins.items()}
        self._wanted: dict[str, dict[str, float]] = {"commands": {}, "angles_rad": {}}
        self._rare = RareLog(logger)
        begun_s = time.time() - live.simulator.time_s
        self._is_by_instruments = settings.by_instruments or address.kind == "announce"
        self._where_rad = (place.latitude_rad, place.longitude_rad)
        self._instruments = Instruments(
            live.simulator.vehicles[self.vehicle], place, fins, lambda time_s: begun_s + time_s
        )
        identity = Identity(settings.system)
        self.link: ImcLink | Announcer
        if address.kind == "announce":
            self.link = Announcer(address, identity, self.vehicle, lambda: self._where_rad)
        else:
            self.link = ImcLink(address, identity, self._on_messages, self._on_met, listen_port=settings.listen_port)
        self._channels = {
            argument: Channel(
                aboard.source.topic(f"imc_cmd_{ending}"), "IMC", "in", "what a system that speaks IMC commands",
                apply=self._applied(f"set_{ending}", argument),
                authority=ended_by({}, self._applied(f"set_{ending}", argument), self._steering),
            )
            for argument, ending in (("commands", "thrusters"), ("angles_rad", "fins"))
        }  # fmt: skip
        self._subscription = live.every(1.0 / settings.rate_hz, self._read, self.link.publish)

    def __enter__(self) -> ImcVehicle:
        self.link.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave."""
        self._subscription.cancel()
        self.link.close()

    def take_ping(self, reading: Reading) -> None:
        """Publish a ping of the sonar, a sensor_msgs/LaserScan. Does not block."""
        if self._is_by_instruments:
            scan = reading.message
            ranges_m = np.asarray(scan.ranges, np.float64)
            self.link.publish([(SONAR, *ping(ranges_m, scan.angle_max - scan.angle_min, scan.range_max))])

    def _read(self, sim: Simulator) -> list[Sent]:
        vehicle = sim.vehicles[self.vehicle]
        if not self.link.is_connected:
            return []
        if not self._is_by_instruments:
            return [(SIMULATOR, *simulated_state(sim, vehicle, self._place))]
        estimate = vehicle.navigation.steering  # the peer steers by it
        if self._settings.system is not None:
            latitude_deg, longitude_deg = self._place.world.degrees(estimate.pose.position_world_m).tolist()
            self._where_rad = math.radians(latitude_deg), math.radians(longitude_deg)
        first = next(iter(vehicle.thrusters.values()))
        rpm = max(-RPM_MAX, min(RPM_MAX, round(first.command * self._settings.full_rpm)))
        return [*self._instruments.read(sim.time_s), (MOTOR, "Rpm", {"value": rpm})]

    def _on_met(self, message: Message) -> None:
        logger.info("system 0x%04X at %s", message.source, self.link.address)

    def _on_messages(self, messages: list[Message]) -> None:
        touched = []
        for each in messages:
            if each.name == "SetThrusterActuation":
                touched.append(self._want_thruster(each.content))
            elif each.name == "SetServoPosition":
                touched.append(self._want_fin(each.content))
        for argument in dict.fromkeys(touched):
            if argument is not None:
                wanted = dict(self._wanted[argument])
                try:
                    self._steering.apply(self._live, self._channels[argument], wanted, DRIVER)
                except (ValueError, RuntimeError) as error:
                    self._rare.warning(f"{self.link.address}: {error}")

    def _want_thruster(self, content: Mapping[str, Any]) -> str | None:
        number, value = content["id"], content["value"]
        if number >= len(self._thrusters) or not math.isfinite(value):
            self._rare.warning(
                f"{self.link.address}: thruster {number}, actuation {value:g}: "
                f"must be a number, of a thruster in [0, {len(self._thrusters) - 1}]"
            )
            return None
        self._wanted["commands"][self._thrusters[number]] = max(-1.0, min(1.0, value))
        return "commands"

    def _want_fin(self, content: Mapping[str, Any]) -> str | None:
        number, value = content["id"], content["value"]
        if number not in self._fins or not math.isfinite(value):
            known = ", ".join(map(str, sorted(self._fins))) or "none"
            self._rare.warning(
                f"{self.link.address}: servo {number}, angle {value:g} rad: must be a number, of a servo ({known})"
            )
            return None
        name, servo = self._fins[number]
        self._wanted["angles_rad"][name] = servo.sign * max(-servo.travel_rad, min(servo.travel_rad, value))
        return "angles_rad"

    def _applied(self, command: str, argument: str) -> Any:
        def apply(live: LiveSimulator, wanted: dict[str, float]) -> None:
            if not wanted:  # the peer has fallen silent
                self._wanted[argument] = {}
            self._steering.give(live, command, **{argument: wanted})

        return apply


def ping(ranges_m: Any, width_rad: float, range_max_m: float) -> tuple[str, dict[str, Any]]:
    """Return a ping as SonarData: for each beam, from starboard to port as in a scan, its range; 0 without an echo.

    A range is a uint16, little-endian, in units of the message's scale_factor [m].
    """
    unit_m = max(range_max_m, 1e-3) / 65535
    units = np.where(np.isfinite(ranges_m), np.round(np.asarray(ranges_m) / unit_m), 0.0)
    return "SonarData", {
        "type": MULTIBEAM, "max_range": min(65535, math.ceil(range_max_m)), "bits_per_point": 16,
        "scale_factor": unit_m, "beam_config": [("BeamConfig", {"beam_width": width_rad, "beam_height": -1.0})],
        "data": np.clip(units, 0, 65535).astype("<u2").tobytes(),
    }  # fmt: skip
