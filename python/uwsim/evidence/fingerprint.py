"""A hash of everything that a short run produces, for checking that different machines give the same results.

    print(fingerprint().whole)

The scenario is flown twice for 10 s: unchanged, and in waves and gusts with the sonar in physics mode. Each kind of
result also has its own hash, so that a difference can be traced.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping import OccupancyMap
from uwsim.mapping.ranging import transform_points
from uwsim.scenario import Scenario, load
from uwsim.scenario.fingerprint import build_fingerprint
from uwsim.scenario.read.validated import validated
from uwsim.simulator.simulator import Simulator

PINGS, PINGS_PER_PICTURE, BETWEEN_PINGS_S = 20, 5, 0.5
VOXEL_M = 0.2
ROUGH_WATER: dict[str, Any] = {
    "surface": {"kind": "jonswap", "significant_height_m": 0.3, "peak_period_s": 3.0},
    "current": [{"kind": "gusts", "sigma_m_s": [0.1, 0.1, 0.0], "correlation_time_s": 5.0}],
}


@dataclass(frozen=True)
class Fingerprint:
    """The fingerprint of a run.

    parts: a digest of each kind of result. machine: machine properties on which results may depend.
    """

    scenario: str
    seed: int
    parts: dict[str, str]
    machine: dict[str, str]

    @property
    def whole(self) -> str:
        """The digest of all parts combined."""
        return _digest("".join(f"{name}:{digest}\n" for name, digest in self.parts.items()).encode())


def fingerprint(
    scenario: str | Path | Scenario = "lake", *, seed: int | None = None, threads: int | None = None
) -> Fingerprint:
    """Fly the scenario, and hash poses, samples, pings in both modes, pictures and maps.

    Raises ScenarioError or ValueError if the scenario or an argument is invalid.
    """
    checked = load(scenario).with_changes(seed=seed)
    digests: dict[str, Any] = {}
    for part, array in results(checked, threads=threads):
        digests.setdefault(part, hashlib.blake2b(digest_size=8)).update(np.ascontiguousarray(array).tobytes())
    parts = {part: digest.hexdigest() for part, digest in digests.items()}
    return Fingerprint(checked.name, checked.seed, parts, machine())


def results(
    scenario: str | Path | Scenario = "lake", *, seed: int | None = None, threads: int | None = None
) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays to be hashed, in order, each with the name of its part.

    Raises the same errors as `fingerprint`.
    """
    checked = load(scenario).with_changes(seed=seed)
    yield from _flown(Simulator(checked, threads=threads), "")
    yield from _flown(Simulator(_rougher(checked), threads=threads), " in rough water")


def machine() -> dict[str, str]:
    """Return the properties of this machine on which results may depend."""
    model = [line for line in _lines("/proc/cpuinfo") if line.startswith("model name")]
    return {
        "uwsim": metadata.version("uwsim"),
        "build": build_fingerprint(),
        "processor": model[0].partition(":")[2].strip() if model else platform.processor(),
        "instruction set": _core.instruction_set(),
        "C library": " ".join(platform.libc_ver()),
        "NumPy": np.__version__,
        "Python": platform.python_version(),
    }


def _rougher(scenario: Scenario) -> Scenario:
    """Return the scenario with waves and gusts added and its sonars in physics mode."""
    data = scenario.given()
    data["water"] = {**scenario.water.given(), **ROUGH_WATER}
    data["vehicles"] = [
        {**vehicle.given(), "sonar": {**vehicle.sonar.given(), "mode": "physics"}} for vehicle in scenario.vehicles
    ]
    return validated(Scenario, data)


def _flown(sim: Simulator, where: str) -> Iterator[tuple[str, NDArray[Any]]]:
    vehicle = next(iter(sim.vehicles.values()))
    vehicle.undock()
    vehicle.set_effort(surge=0.6, heave=-0.2, yaw=0.1)
    for lamp in vehicle.lamps.values():
        lamp.on = True
    streams = [sensor.stream() for sensor in vehicle.sensors.values()]
    occupancy = OccupancyMap(resolution_m=VOXEL_M)
    for number in range(PINGS):
        sim.advance(BETWEEN_PINGS_S)
        pose, velocity = vehicle.pose, vehicle.velocity
        for array in (pose.position_world_m, pose.orientation_xyzw, *velocity.to_dict().values()):
            yield f"poses{where}", array
        for stream in streams:
            yield from ((f"samples{where}", array) for array in stream.take().parts)
        ping = vehicle.sonar.ping()
        yield f"ranges{where}", ping.ranges_m
        yield f"intensities{where}", ping.intensity_db
        yield f"labels{where}", ping.labels
        echoes = ping.points_sonar_m[np.isfinite(ping.ranges_m)]
        points = transform_points(echoes, ping.world_from_sonar)  # NumPy's matrix products depend on the CPU
        occupancy.insert_scan(points, ping.world_from_sonar[:3, 3])
        if number % PINGS_PER_PICTURE == 0:
            for camera in vehicle.cameras.values():
                yield f"pictures{where}", camera.capture().rgb
    yield f"map{where}", np.frombuffer(occupancy.to_bytes("ot"), np.uint8)


def _lines(path: str) -> list[str]:
    try:
        return Path(path).read_text().splitlines()
    except OSError:
        return []


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()
