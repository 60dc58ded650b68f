"""A multibeam model, as read from its YAML file: its fan and, for physics mode, its acoustic parameters."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictBool, model_validator

from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, YawPitchRoll, broken

WIRE_NUMBERS = (1, 4)
BeamWidth = Annotated[float, InRange(0.01, 80, "deg")]
NoiseLevel = Annotated[float, InRange(-100, 200, "dB")]
DetectionThreshold = Annotated[float, InRange(-20, 60, "dB")]
Receivers = Literal[1, 2]
FrequencyHz = Annotated[float, InRange(1e3, 5e6, "Hz")]


class SonarMounting(Model):
    """The pose of the sonar head on the vehicle's mount: x forward, y left, z up.

    position_m: position relative to the mount.
    """

    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)

    @property
    def orientation_xyzw(self) -> tuple[float, float, float, float]:
        """The orientation of the head relative to the mount."""
        x, y, z, w = of_yaw_pitch_roll_deg(self.yaw_pitch_roll_deg).tolist()
        return x, y, z, w


class SonarNoise(Model):
    """The receiver's noise and its effects.

    level_db: re 1 uPa, in the receiver's band. detection_threshold_db: signal-to-noise ratio at which the probability
    of detection is 0.5. false_detections: whether noise may be detected as a bottom. range: whether ranges have errors.
    """

    level_db: NoiseLevel = 45.0
    detection_threshold_db: DetectionThreshold = 13.0
    false_detections: bool = True
    range: bool = True


class SonarNoiseChanges(Model):
    """Values of SonarNoise that override the model's; omitted values remain the model's.

    level_db: re 1 uPa, in the receiver's band. detection_threshold_db: signal-to-noise ratio at which the probability
    of detection is 0.5. false_detections: whether noise may be detected as a bottom. range: whether ranges have errors.
    """

    level_db: NoiseLevel | None = None
    detection_threshold_db: DetectionThreshold | None = None
    false_detections: bool | None = None
    range: bool | None = None

    def of(self, noise: SonarNoise) -> SonarNoise:
        """Apply these overrides to a model's noise."""
        return noise.model_copy(update={key: value for key, value in dict(self).items() if value is not None})


class SonarBand(Model):
    """One of the instrument's frequencies, with its parameters there.

    frequency_hz: centre frequency. field_of_view_deg: opening angle of the fan. range_max_m: ranges at or beyond it
    are not echoes. range_limit_m: the published decoder's limit, beyond which a range means no echo; range_max_m by
    default. beam_width_along_deg: beam width of the transmitter, across the plane of the fan, -3 dB one way.
    beam_width_across_deg: width of an unsteered receiving beam, within that plane, -3 dB one way. pulse_length_s,
    bandwidth_hz: parameters of the pulse. source_level_db: re 1 uPa at 1 m. directivity_index_db: directivity of an
    unsteered receiving beam. The last six are for physics mode: all or none.
    """

    frequency_hz: FrequencyHz
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
            raise broken("missing: physics mode needs it with the others", at=(missing[0],))
        if self.range_limit_m is not None and self.range_limit_m > self.range_max_m:
            rule = f"must be at most range_max_m, {self.range_max_m:g} m"
            raise broken(rule, at=("range_limit_m",), value=self.range_limit_m, unit="m")
        if self.bandwidth_hz is not None and self.pulse_length_s is not None:
            if self.bandwidth_hz > self.frequency_hz:
                rule = f"must be at most the frequency, {self.frequency_hz:g} Hz"
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


class SonarModel(Model, defer_build=False):  # a part of Scenario that is also read alone
    """A commercial multibeam.

    beams: number of beams, evenly spaced over the field of view, about the head's forward axis. wire_number: its number
    among the four models of the published simulator. dual_swath: whether a ping has two fans. tilt_rate_deg_s: rate at
    which the head tilts. mounting: pose on the vehicle's mount. noise: receiver noise in physics mode. multipath:
    whether, in physics mode, echoes by more than one bounce are received. receiver_tilt_deg: tilt of each of two
    receivers. ping_rate_max_hz: limit set by the electronics. receivers: number of flat arrays, one facing ahead or two
    ("dual RX"), each turned to its side by receiver_tilt_deg; a model with one receiver and a tilt is also available
    with two. frequencies: a scenario selects one.
    """

    name: Name
    description: str = ""
    wire_number: Annotated[int, InRange(*WIRE_NUMBERS)] | None = None
    dual_swath: bool = False
    beams: Annotated[int, InRange(2, 8192)]
    ping_rate_max_hz: Annotated[float, InRange(0.01, 1000, "Hz")] = 50.0
    tilt_rate_deg_s: Annotated[float, InRange(0.01, 1000, "deg/s")] = 5.0
    receivers: Receivers = 1
    receiver_tilt_deg: Annotated[float, InRange(0, 90, "deg")] | None = None
    mounting: SonarMounting = SonarMounting.model_construct()
    noise: SonarNoise = SonarNoise.model_construct()
    multipath: StrictBool = False
    frequencies: Annotated[tuple[SonarBand, ...], Field(min_length=1, max_length=32)]

    @model_validator(mode="after")
    def _has_each_frequency_once(self) -> SonarModel:
        seen: set[float] = set()
        for index, band in enumerate(self.frequencies):
            if band.frequency_hz in seen:
                at = ("frequencies", index, "frequency_hz")
                raise broken("is given twice", at=at, value=band.frequency_hz, unit="Hz")
            seen.add(band.frequency_hz)
        if self.receivers == 2 and self.receiver_tilt_deg is None:
            raise broken("missing: two receivers need it", at=("receiver_tilt_deg",))
        return self

    def band(self, frequency_hz: float | None = None) -> SonarBand:
        """Return the parameters at a frequency; None selects the only one. Raises ValueError."""
        known = ", ".join(f"{band.frequency_hz:.12g}" for band in self.frequencies)
        if frequency_hz is None and len(self.frequencies) > 1:
            raise ValueError(f"frequency_hz: missing: {self.name} works at {known} Hz, choose one")
        for band in self.frequencies:
            if frequency_hz is None or band.frequency_hz == frequency_hz:
                return band
        raise ValueError(f"frequency_hz = {frequency_hz:.12g} Hz: {self.name} works at {known} Hz")

    def acoustic_band(self, frequency_hz: float | None = None) -> SonarBand:
        """Return the parameters at a frequency for physics mode. Raises ValueError if any are missing."""
        band = self.band(frequency_hz)
        for key in ACOUSTIC:
            if getattr(band, key) is None:
                raise ValueError(f"{self.name} at {band.frequency_hz:.12g} Hz: {key}: missing: physics mode needs it")
        return band

    def with_receivers(self, receivers: Receivers, frequency_hz: float | None = None) -> SonarModel:
        """Return the model with this number of receivers, at a frequency. Two receivers double the number of beams.

        Raises ValueError if the model cannot have this number.
        """
        if receivers == self.receivers:
            return self
        if receivers == 1 or self.receiver_tilt_deg is None:
            raise ValueError(f"receivers = {receivers}: {self.name} has {self.receivers}")
        band, apart_deg = self.band(frequency_hz), 2 * self.receiver_tilt_deg
        wider = band.model_copy(update={"field_of_view_deg": band.field_of_view_deg + apart_deg})
        if not apart_deg <= band.field_of_view_deg <= 360 - apart_deg:
            sectors = f"sectors of {band.field_of_view_deg:g} deg, {apart_deg:g} deg apart, do not meet"
            raise ValueError(f"receivers = 2: {self.name} at {band.frequency_hz:.12g} Hz: {sectors}")
        return self.model_copy(update={"receivers": 2, "beams": 2 * self.beams, "frequencies": (wider,)})

    def within(self, range_max_m: float) -> SonarModel:
        """Return the model with its maximum range limited."""
        bands = [
            band.model_copy(
                update={
                    "range_max_m": min(band.range_max_m, range_max_m),
                    "range_limit_m": None if band.range_limit_m is None else min(band.range_limit_m, range_max_m),
                }
            )
            for band in self.frequencies
        ]
        return self.model_copy(update={"frequencies": tuple(bands)})


def load_sonar(source: int | str | Path, folder: Path | None = None) -> SonarModel:
    """Load a model by its wire number (1 to 4), packaged name ("em2040-04") or path. Raises ScenarioError."""
    if isinstance(source, int):
        return _em2040(source)
    return read_spec(SonarModel, source, "sonars", folder)


@cache
def _em2040(number: int) -> SonarModel:
    """Return a packaged model; cached, since it is requested often."""
    return read_spec(SonarModel, f"em2040-{number}", "sonars")


SonarMode = Literal["geometry", "physics"]
