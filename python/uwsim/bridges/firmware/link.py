"""Aids for a firmware that ArduPilot's JSON interface lacks, by MAVLink: estimate, origin, pressure, voltage."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from uwsim.base.agenda import NEVER, Rank, next_tick
from uwsim.bridges.ardusub.ardusub import ArduSub
from uwsim.bridges.ardusub.auxiliary import CENTRE_US
from uwsim.bridges.doors.datagrams import ALL, Address, Datagrams
from uwsim.bridges.firmware.kept_parameters import KeptParameters
from uwsim.bridges.mavlink.telemetry import odometry
from uwsim.mapping.files.georeference import Home

PERIOD_NS, SECOND_NS = 50_000_000, 1_000_000_000
LOCAL_FRD, VISUAL_ODOMETRY, REAL32 = 20, 197, 9  # MAV_FRAME, MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY, MAV_PARAM_TYPE
SAG_V, SAG_US, SAGGING = 0.5, 500, 6
"""ArduSub's simulated battery loses 0.5 V for each 500 us of the first six outputs (AP_HAL_SITL)."""
VOLTAGE_STEP_V, HEIGHT_STEP_M = 0.02, 0.002
BOOT_NS = 3_000_000_000
"""Time in which the barometer shows the surface, as on a deck: ArduSub takes its first pressure for the surface's."""
ATMOSPHERE_PA, PA_PER_M = 101325.0, 1024 * 9.80665
"""ArduSub's simulated barometer (AP_Baro_HIL): pressure at the surface, and its increase with depth."""
BUFFER_BYTES = 1 << 20


class FirmwareLink:
    """Sends a firmware what its navigation needs, 20 times per simulated second, until it is closed.

    ODOMETRY contains the vehicle's own estimate (IMU, compass, DVL, depth), never the truth; see Vehicle.estimate.
    SET_GPS_GLOBAL_ORIGIN is repeated every second until the firmware confirms it. The parameter SIM_BARO_GLITCH makes
    the simulated barometer show the pressure at the vehicle's sensor, with waves and the water's density, and
    SIM_BATT_VOLTAGE the voltage of the vehicle's battery, if that is one of cells. Messages are sent while the firmware
    waits for a line, so that they arrive at the same frame in every run; in a live simulator they are left out if it is
    late. Only a socket of the firmware's process, or of one that it has started, is heard.

    home: where the world's origin is. system: the firmware's MAVLink system id. needed: parameters, if the firmware may
    have kept others; see KeptParameters. The attribute address is that to which the firmware must send its MAVLink:
    HOST:PORT, by UDP. Raises OSError or MissingExtraError.
    """

    def __init__(self, home: Home, system: int = 1, needed: Mapping[str, float] = MappingProxyType({})) -> None:
        from pymavlink.dialects.v20 import ardupilotmega as dialect

        self._home, self._system = home, system
        self._mav: Any = dialect.MAVLink(None, srcSystem=system, srcComponent=VISUAL_ODOMETRY)
        self._mav.robust_parsing = True
        self._datagrams = Datagrams(("127.0.0.1", 0), buffer_bytes=BUFFER_BYTES)
        self.address = f"127.0.0.1:{self._datagrams.port}"
        self._peer: Address | None = None
        self._ardusub: ArduSub | None = None
        self._pid = 0
        self._step_ns, self._resets, self._booted_ns = 0, 0, 0
        self._values: dict[bytes, float] = {}
        self._kept = KeptParameters(needed, self._mav, system, self._send)
        self.has_origin = False
        self.due_tick = NEVER

    def attach(self, ardusub: ArduSub, pid: int) -> None:
        """Aid the firmware of this process, which steps the simulator. Raises ValueError for one without an IMU."""
        self._ardusub, self._pid = ardusub, pid
        sim = ardusub.simulator
        self._step_ns = round(1e9 * sim.step_s)
        self._booted_ns = sim.time_ns + BOOT_NS
        _ = ardusub.flown.navigation.steering
        self._plan(sim.tick)
        sim.agenda.add(self, Rank.DELIVERY, self._act, jump=self._plan)

    def close(self) -> None:
        """Send nothing more."""
        if self._ardusub is not None:
            self._ardusub.simulator.agenda.remove(self)
        self._datagrams.close()

    def _plan(self, tick: int) -> None:
        self.due_tick = next_tick(tick, PERIOD_NS, self._step_ns)

    def _act(self, tick: int) -> None:
        assert self._ardusub is not None
        ardusub, sim = self._ardusub, self._ardusub.simulator
        self._plan(tick)
        if not ardusub.is_ready():
            return
        self._receive()
        if ardusub.counts.resets != self._resets:  # another program, which has nothing yet; the rest was from the last
            self._resets, self.has_origin, self._peer = ardusub.counts.resets, False, None
            self._booted_ns = sim.time_ns + BOOT_NS
            self._values.clear()
        if self._peer is None:
            return
        estimate = ardusub.flown.navigation.steering
        pose, velocity = estimate.pose, estimate.velocity
        motion = np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])
        place = pose.position_world_m, pose.orientation_xyzw
        self._send(odometry(self._mav, sim.time_ns // 1000, LOCAL_FRD, *place, motion))
        self._send_pressure(ardusub)
        if tick == next_tick(tick - 1, SECOND_NS, self._step_ns):
            if not self.has_origin:
                origin = round(1e7 * self._home.lat_deg), round(1e7 * self._home.lon_deg)
                self._send(self._mav.set_gps_global_origin_encode(self._system, *origin, 0))
            self._send_voltage(ardusub)
            self._kept.act()

    def _send_pressure(self, ardusub: ArduSub) -> None:
        """Move the height from which ArduSub computes the pressure by what separates it from the vehicle's."""
        sensor = next((each for each in ardusub.flown.sensors.values() if each.kind == "pressure"), None)
        if sensor is not None:
            is_booting = ardusub.simulator.time_ns < self._booted_ns
            shown_pa = ATMOSPHERE_PA if is_booting else float(sensor.read(noise=ardusub.with_noise))
            height_m = (ATMOSPHERE_PA - shown_pa) / PA_PER_M - float(ardusub.flown.pose.position_world_m[2])
            self._set(b"SIM_BARO_GLITCH", height_m, HEIGHT_STEP_M)

    def _send_voltage(self, ardusub: ArduSub) -> None:
        """Set the voltage from which ArduSub subtracts its own sag, so that the rest is the battery's."""
        sags = (SAG_V * abs(float(pulse_us) - CENTRE_US) / SAG_US for pulse_us in ardusub.outputs_us[:SAGGING])
        self._set(b"SIM_BATT_VOLTAGE", ardusub.flown.battery.voltage_v + sum(sags), VOLTAGE_STEP_V)

    def _set(self, name: bytes, value: float, step: float) -> None:
        """Set a parameter if it is known and has changed by a step."""
        if math.isfinite(value) and not abs(value - self._values.get(name, math.nan)) < step:
            self._values[name] = value
            self._send(self._mav.param_set_encode(self._system, 1, name, value, REAL32))

    def _receive(self) -> None:
        for data, sender in self._datagrams.received(ALL):
            self._peer = self._peer or (sender if has_udp_port(self._pid, sender[1]) else None)
            if sender == self._peer and not (self.has_origin and self._kept.is_done):  # the rest is of no interest
                for message in self._mav.parse_buffer(data) or ():
                    self.has_origin |= message.get_type() == "GPS_GLOBAL_ORIGIN"
                    self._kept.note(message)

    def _send(self, message: Any) -> None:
        assert self._peer is not None
        self._datagrams.send(message.pack(self._mav), self._peer)


def has_udp_port(session: int, port: int) -> bool:
    """Return whether a process of a session has the UDP socket of a port."""
    rows = (line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:])
    sockets = {f"socket:[{row[9]}]" for row in rows if int(row[1].rpartition(":")[2], 16) == port}
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # of a process that has ended
            if os.getsid(int(process.name)) == session and sockets & {*map(os.readlink, (process / "fd").iterdir())}:
                return True
    return False
