"""The options of a mission that is flown over a rosbridge: `uwsim run --connect URL`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.options import option
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.flight.attachment import OtherFlight

if TYPE_CHECKING:
    from uwsim.flight.record import FlightRecord


@dataclass(frozen=True)
class RemoteOptions(OtherFlight):
    """The options of a remote flight."""

    switch = "connect"

    connect: str | None = option(
        None, f"Fly a vehicle over a rosbridge instead, such as ws://127.0.0.1:{ROSBRIDGE_PORT} of `uwsim serve`."
    )
    lockstep: bool = option(False, "With --connect: the simulator is paused while the mission computes.")
    odometry: str | None = option(None, "With --connect: the topic of the vehicle's pose. Default: odom.")

    def fly(self, mission: Path, out: Path, **options: Any) -> FlightRecord:
        """Fly it at the rosbridge; see fly_remote."""
        from uwsim.bridges.remote.flight import fly_remote

        assert self.connect is not None
        return fly_remote(
            mission, self.connect, out, odometry=self.odometry or "odom", lockstep=self.lockstep, **options
        )
