"""A firmware that flies a simulated vehicle: its process, its parameters and its link, started together."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from types import MappingProxyType

import numpy as np

from uwsim.bridges.ardusub.ardusub import PORTS_APART, ArduSub
from uwsim.bridges.firmware.firmware import NAVIGATION, RC_PORT, SIMULATED, Firmware, FirmwareError, Serials
from uwsim.bridges.firmware.link import FirmwareLink
from uwsim.bridges.mavlink.earth import FRD, place_of
from uwsim.mapping.files.georeference import Home

STATION = "127.0.0.1:14550"
START_S, LOOK_S = 15.0, 0.05
FRAME_CONFIG = {"vectored": 1, "vectored_6dof": 2}
LIGHTS1, MOUNT_TILT, SERVO_MOUNT = 181, 7, 1  # SERVOn_FUNCTION, MNT1_TYPE
METRE_OF_WATER_PA = 9800
"""The pressure that ArduSub takes for a metre, times BARO_SPEC_GRAV."""
BARO_RND_M = 0.02
"""The noise of the simulated barometer in ArduPilot's own parameters for ArduSub."""
COMPASS_OFS = (5.0, 13.0, -18.0)
"""Offsets of the simulated compasses [mG], which they have by default (SIM_MAG1_OFS)."""
MG_PER_UT = 10
EEPROM, GLITCH = "eeprom.bin", "SIM_BARO_GLITCH"


@contextmanager
def firmware_flying(
    ardusub: ArduSub,
    binary: Path,
    *,
    station: str = STATION,
    files: Sequence[Path] = (),
    parameters: Mapping[str, float] = MappingProxyType({}),
    folder: Path | None = None,
    home: Home | None = None,
    system: int = 1,
) -> Iterator[Firmware]:
    """Start a firmware that flies the vehicle of an ArduSub; yield it after its first frame.

    It navigates by the vehicle's own estimate, without GPS. station: HOST:PORT, the UDP address to which it sends its
    MAVLink. files: parameter files, such as those of a real vehicle; what the simulated vehicle and its navigation need
    takes precedence over them and over what the folder has kept, and `parameters` over that. home: by default the
    origin of the scenario's world, as in place_of. folder: see Firmware. system: its MAVLink system id, which differs
    between the firmwares of a world.
    Raises FirmwareError, or ValueError for an address.
    """
    if home is None:
        latitude_deg, longitude_deg = map(float, place_of(ardusub.simulator.scenario).degrees(np.zeros(3)))
        home = Home(latitude_deg, longitude_deg)
    values = {**needed(ardusub), **parameters}
    has_kept = folder is not None and (folder / EEPROM).exists()
    checked = {name: value for name, value in values.items() if name != GLITCH} if has_kept else {}
    with closing(FirmwareLink(home, system, checked)) as link:
        firmware = Firmware(
            binary, ardusub.port, Serials(checked_address(station), link.address), home, files=files,
            parameters=values, folder=folder, system=system, rc_port=RC_PORT + PORTS_APART * (system - 1),
        )  # fmt: skip
        with firmware:
            _await_frame(ardusub, firmware)
            ardusub.require_alive = firmware.require_running
            link.attach(ardusub, firmware.pid)
            yield firmware


def needed(ardusub: ArduSub) -> dict[str, float]:
    """Return the parameters that a simulated vehicle in its water needs, by ArduSub's names."""
    water, noisy = ardusub.simulator.world.water, ardusub.with_noise
    spec_grav = float(water.density_at_kg_m3(0.0)) * water.gravity_m_s2 / METRE_OF_WATER_PA
    found = {
        **NAVIGATION, **SIMULATED, "FRAME_CONFIG": FRAME_CONFIG[ardusub.frame], "BARO_SPEC_GRAV": spec_grav,
        "SIM_BARO_RND": 0.0 if noisy else BARO_RND_M,
        GLITCH: -float(ardusub.flown.pose.position_world_m[2]),  # the surface, until FirmwareLink sets it
    }  # fmt: skip
    compass = next((each for each in ardusub.flown.sensors.values() if each.kind == "compass"), None)
    iron_ut = compass.spec.parameters["hard_iron_ut"] if noisy and compass is not None else (0.0, 0.0, 0.0)
    for axis, offset, iron, sign in zip("XYZ", COMPASS_OFS, iron_ut, FRD, strict=True):
        for number in (1, 2, 3):
            found[f"COMPASS_OFS{'' if number == 1 else number}_{axis}"] = offset
            found[f"SIM_MAG{number}_OFS_{axis}"] = offset - MG_PER_UT * sign * iron
    if ardusub.lights is not None:
        found[f"SERVO{ardusub.lights}_FUNCTION"] = LIGHTS1
    if ardusub.tilt is not None:
        found |= {f"SERVO{ardusub.tilt}_FUNCTION": MOUNT_TILT, "MNT1_TYPE": SERVO_MOUNT}
    return found


def checked_address(text: str) -> str:
    """Return an IPv4 address and port as text. Raises ValueError."""
    parts = re.fullmatch(r"(\d{1,3}(?:\.\d{1,3}){3}):(\d{1,5})", text)
    if parts is None or max(map(int, parts[1].split("."))) > 255 or not 1 <= int(parts[2]) <= 65535:
        raise ValueError(f"station = '{text[:40]}': must be an IPv4 address and a port, such as {STATION}")
    return text


def _await_frame(ardusub: ArduSub, firmware: Firmware) -> None:
    began_s = time.monotonic()
    while not ardusub.is_waiting(LOOK_S):
        firmware.require_running()
        if time.monotonic() > began_s + START_S:
            rule = "is it an ArduSub that was compiled for simulation (SITL)?"
            raise FirmwareError(f"{firmware.binary}: has sent no frame within {START_S:g} s: {rule}")
