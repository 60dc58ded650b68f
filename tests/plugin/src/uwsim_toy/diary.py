"""`uwsim run --diary FILE`: the depth of the first vehicle, as the flight goes on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from uwsim.base.options import option
from uwsim.flight.attachment import Attachment, AttachmentOptions, Departure
from uwsim.simulator.simulator import Simulator


@dataclass(frozen=True)
class DiaryOptions(AttachmentOptions):
    """The options of a diary."""

    switch = "diary"

    diary: Path | None = option(None, "Write time and depth into this file.", metavar="FILE", is_written=True)
    diary_every: float = option(10.0, "Simulated time between the diary's lines.", bounds=(1, 1e6, "s"))

    def attach(self, flight: Departure) -> Attachment:
        """Return the diary of a flight."""
        assert self.diary is not None
        return Diary(flight.sim, self.diary, self.diary_every)


class Diary(Attachment):
    """Writes a line at each `due_tick`, when the simulator calls `observe`."""

    def __init__(self, simulator: Simulator, path: Path, every_s: float) -> None:
        self._simulator, self._path = simulator, path
        self._every, self.due_tick = round(every_s / simulator.scenario.step_s), simulator.tick
        self._lines: list[str] = []

    @property
    def observer(self) -> Diary:
        """This diary."""
        return self

    def observe(self) -> None:
        """Note time and depth."""
        self.due_tick += self._every
        self._lines.append(f"{self._simulator.time_s:.0f} s: {self._simulator.rov.telemetry().depth_m:.1f} m")

    def try_close(self) -> OSError | None:
        """Write the file, however the flight ended."""
        try:
            self._path.write_text("\n".join([*self._lines, ""]))
        except OSError as error:
            return error
        return None
