"""The options of a flight's raw survey: `--raw FILE --offsets ... --uncertainty ...`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from uwsim.base.options import OptionError, option
from uwsim.flight.attachment import Attachment, AttachmentOptions, Departure

if TYPE_CHECKING:
    from uwsim.flight.raw_places import PatchErrors
    from uwsim.scoring.tpu import Uncertainties


@dataclass(frozen=True)
class RawOptions(AttachmentOptions):
    """The options of a raw survey. From Python, offsets and uncertainty may also be what they are parsed to."""

    switch = "raw"

    raw: Path | None = option(
        None,
        "Also write every mapped ping with its travel times for survey software as .gsf, or a line of side scan as "
        ".xtf; they need earth: in the scenario.",
        is_written=True,
    )
    offsets: str | None = option(
        None,
        "With --raw: errors of installation in that file, to be found by calibration: roll, pitch, heading [deg], "
        "latency [s], such as roll=0.5,latency=0.02.",
    )
    uncertainty: str | None = option(
        None,
        "With --raw: standard deviations of the survey's instruments, for the errors that the file states and the "
        "order of S-44: roll, pitch, heading, mount, angle [deg], position, depth, heave, tide, lever, "
        "range [m], latency [s], sound_speed, surface_speed [m/s], such as roll=0.05,position=0.5.",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.errors, self.known  # refused before the world is built

    @property
    def errors(self) -> PatchErrors | None:
        """The errors of installation. Raises ValueError."""
        from uwsim.flight.raw_places import PatchErrors

        return PatchErrors.parse(self.offsets) if isinstance(self.offsets, str) else self.offsets

    @property
    def known(self) -> Uncertainties | None:
        """The uncertainties of the instruments. Raises ValueError."""
        from uwsim.scoring.tpu import Uncertainties

        return Uncertainties.parse(self.uncertainty) if isinstance(self.uncertainty, str) else self.uncertainty

    def attach(self, flight: Departure) -> Attachment:
        """Return what writes the raw survey of a flight with a map. Raises ValueError."""
        from uwsim.flight.raw_survey import RawFlight, raw_writer

        if not flight.has_map:
            raise OptionError(f"--raw {self.raw}: needs a flight that maps: give --map")
        assert self.raw is not None
        pose: Literal["truth", "filter"] = "truth" if flight.request is None else flight.request.estimate
        return RawFlight(raw_writer(flight.sim, Path(self.raw), self.errors, self.known, pose))
