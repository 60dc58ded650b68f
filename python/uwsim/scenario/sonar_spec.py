"""A multibeam's model, as read from its YAML file: its fan, and what makes it an acoustic instrument."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.scenario.document import read_document
from uwsim.scenario.fields import InRange, Model, Name, Point3, YawPitchRoll, broken
from uwsim.scenario.material_spec import ROCK, Backscatter
from uwsim.scenario.messages import validated
from uwsim.scenario.paths import assets_folder, find_yaml

WIRE_NUMBERS = (1, 4)
BeamWidth = Annotated[float, InRange(0.01, 80, "deg")]
Decibels = Annotated[float, InRange(-100, 300, "dB")]
FrequencyKhz = Annotated[float, InRange(1, 5000, "kHz")]


class SonarMounting(Model):
    """Where the head is on the vehicle's mount: x forward, y left, z up."""

    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)

    @property
    def orientation_xyzw(self) -> tuple[float, float, float, float]:
        """The head's axes in the mount's."""
        x, y, z, w = Rotation.from_euler("ZYX", self.yaw_pitch_roll_deg, degrees=True).as_quat().tolist()
        return x, y, z, w


class SonarNoise(Model):
    """What stands against the echo, and what it does.

    level_db: re 1 uPa, in the receiver's band. detection_threshold_db: the signal-to-noise ratio that is detected half
    of the time. false_detections: whether noise may be taken for a bottom. range: whether ranges err.
    """

    level_db: Decibels = 45.0
    detection_threshold_db: Annotated[float, InRange(-20, 60, "dB")] = 13.0
    false_detections: bool = True
    range: bool = True


class SonarBand(Model):
    """A frequency that the instrument works at, and its figures there.

    range_max_m: a range at or past it is no echo. range_limit_m: past it the published decoder takes a range for no
    echo; range_max_m by default. Beam widths: -3 dB, one way; along: the transmitter's, across the fan's plane; across:
    a receiving beam's, within it. The last six are for physics mode: all or none.
    """

    frequency_khz: FrequencyKhz
    field_of_view_deg: Annotated[float, InRange(0.1, 360, "deg")]
    range_max_m: Annotated[float, InRange(0.1, 12_000, "m")]
    range_limit_m: Annotated[float, InRange(0.1, 12_000, "m")] | None = None
    beam_width_along_deg: BeamWidth | None = None
    beam_width_across_deg: BeamWidth | None = None
    pulse_length_s: Annotated[float, InRange(1e-6, 1, "s")] | None = None
    bandwidth_hz: Annotated[float, InRange(1, 5e6, "Hz")] | None = None
    source_level_db: Annotated[float, InRange(50, 300, "dB")] | None = None
    directivity_index_db: Annotated[float, InRange(0, 60, "dB")] | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> SonarBand:
        acoustic = {key: getattr(self, key) for key in ACOUSTIC}
        missing = [key for key, value in acoustic.items() if value is None]
        if missing and len(missing) < len(acoustic):
            raise broken("missing: physics mode needs it beside the others", at=(missing[0],))
        if self.range_limit_m is not None and self.range_limit_m > self.range_max_m:
            rule = f"must be at most range_max_m, {self.range_max_m:g} m"
            raise broken(rule, at=("range_limit_m",), value=self.range_limit_m, unit="m")
        if self.bandwidth_hz is not None and self.pulse_length_s is not None:
            if self.bandwidth_hz > 1000 * self.frequency_khz:
                rule = f"must be at most the frequency, {1000 * self.frequency_khz:g} Hz"
                raise broken(rule, at=("bandwidth_hz",), value=self.bandwidth_hz, unit="Hz")
            if self.bandwidth_hz * self.pulse_length_s < 0.99:
                rule = f"must be at least 1 / bandwidth_hz, {1 / self.bandwidth_hz:.3g} s, as for any pulse"
                raise broken(rule, at=("pulse_length_s",), value=self.pulse_length_s, unit="s")
        return self


ACOUSTIC = (
    "beam_width_along_deg",
    "beam_width_across_deg",
    "pulse_length_s",
    "bandwidth_hz",
    "source_level_db",
    "directivity_index_db",
)


class SonarModel(Model):
    """A multibeam as one buys it.

    beams: spread evenly over the field of view, about the head's forward axis. wire_number: of the published
    simulator's four. ping_rate_max_hz: of the electronics. frequencies: to choose one of.
    """

    name: Name
    description: str = ""
    wire_number: Annotated[int, InRange(*WIRE_NUMBERS)] | None = None
    dual_swath: bool = False
    beams: Annotated[int, InRange(2, 8192)]
    ping_rate_max_hz: Annotated[float, InRange(0.01, 1000, "Hz")] = 50.0
    tilt_rate_deg_s: Annotated[float, InRange(0.01, 1000, "deg/s")] = 5.0
    mounting: SonarMounting = SonarMounting()
    noise: SonarNoise = SonarNoise()
    frequencies: Annotated[tuple[SonarBand, ...], Field(min_length=1, max_length=32)]

    @model_validator(mode="after")
    def _has_each_frequency_once(self) -> SonarModel:
        taken: set[float] = set()
        for index, band in enumerate(self.frequencies):
            if band.frequency_khz in taken:
                at = ("frequencies", index, "frequency_khz")
                raise broken("is there twice", at=at, value=band.frequency_khz, unit="kHz")
            taken.add(band.frequency_khz)
        return self

    def band(self, frequency_khz: float | None = None) -> SonarBand:
        """The figures at a frequency; it may be left out where there is one only. Raises ValueError."""
        known = ", ".join(f"{band.frequency_khz:g}" for band in self.frequencies)
        if frequency_khz is None and len(self.frequencies) > 1:
            raise ValueError(f"frequency_khz: missing: {self.name} works at {known} kHz, choose one")
        for band in self.frequencies:
            if frequency_khz is None or band.frequency_khz == frequency_khz:
                return band
        raise ValueError(f"frequency_khz = {frequency_khz:g} kHz: {self.name} works at {known} kHz")

    def within(self, range_m: float) -> SonarModel:
        """The same, set to see no farther."""
        bands = [
            band.model_copy(
                update={
                    "range_max_m": min(band.range_max_m, range_m),
                    "range_limit_m": None if band.range_limit_m is None else min(band.range_limit_m, range_m),
                }
            )
            for band in self.frequencies
        ]
        return self.model_copy(update={"frequencies": tuple(bands)})

    def core_model(self, frequency_khz: float | None = None) -> _core.MultibeamModel:
        """Its fan as the core takes it. Raises ValueError."""
        band = self.band(frequency_khz)
        return _core.MultibeamModel(
            name=self.description or self.name,
            number=self.wire_number or 0,
            beams=self.beams,
            field_of_view_rad=math.radians(band.field_of_view_deg),
            range_max_m=band.range_max_m,
            range_limit_m=band.range_limit_m,
            frequency_hz=1e3 * band.frequency_khz,
            dual_swath=self.dual_swath,
            ping_rate_max_hz=self.ping_rate_max_hz,
            tilt_rate_rad_s=math.radians(self.tilt_rate_deg_s),
        )

    def core_acoustics(
        self,
        frequency_khz: float | None = None,
        *,
        bending: bool = False,
        rays_per_beam: int = 8,
        bottoms: Sequence[Backscatter] = (),
    ) -> _core.AcousticSpec:
        """What the core needs for physics mode. bottoms: by label, rock beyond. Raises ValueError."""
        band = self.band(frequency_khz)
        spec, figures = _core.AcousticSpec(), _core.SonarFigures()
        for key in ACOUSTIC:
            value = getattr(band, key)
            if value is None:
                raise ValueError(f"{self.name} at {band.frequency_khz:g} kHz: {key}: missing: physics mode needs it")
            name = key.replace("_deg", "_rad")
            setattr(figures, name, math.radians(value) if key.endswith("_deg") else value)
        figures.frequency_hz = 1e3 * band.frequency_khz
        figures.noise_level_db = self.noise.level_db
        figures.detection_threshold_db = self.noise.detection_threshold_db
        figures.check()
        spec.figures = figures
        spec.rays_per_beam = rays_per_beam
        spec.false_detections = self.noise.false_detections
        spec.range_noise = self.noise.range
        spec.bending = bending
        spec.bottom = ROCK.core_material()
        spec.materials = [bottom.core_material() for bottom in bottoms]
        return spec


def load_sonar(source: int | str | Path, folder: Path | None = None) -> SonarModel:
    """Load a model from its number on the wire (1 to 4), a packaged name ("em2040-04") or a path. ScenarioError."""
    if isinstance(source, int):
        source = f"em2040-{source}"
    beside = (folder or Path()) / source
    path = beside if beside.is_file() else find_yaml(source, "sonars")
    document = read_document(path, path.name if assets_folder() in path.parents else str(path))
    return validated(SonarModel, document.values, document, folder=path.resolve().parent)


SonarMode = Literal["geometry", "physics"]
