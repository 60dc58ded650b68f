"""A vehicle's multibeam in a scenario: which model, and how it is simulated."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, PlainSerializer, PlainValidator, StrictBool, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import AssetName, InRange, Model, NoseDown, broken
from uwsim.scenario.spec.sonar import (
    WIRE_NUMBERS,
    FrequencyHz,
    Receivers,
    SonarMode,
    SonarModel,
    SonarNoise,
    SonarNoiseChanges,
    load_sonar,
)

SonarNumber = Annotated[int, InRange(*WIRE_NUMBERS)]
SonarName = Annotated[str, AssetName("sonars")]


def _sonar_model(value: object, info: ValidationInfo) -> object:
    folder = (info.context or {}).get("folder")
    if isinstance(value, str | Path):
        return load_sonar(value, folder=folder)
    if isinstance(value, Mapping):
        return validated(SonarModel, value, folder=folder)
    if isinstance(value, SonarModel):
        return value
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise broken("must be a whole number, a model's name or the path of its file, or the model itself")
    low, high = WIRE_NUMBERS
    if not low <= value <= high:
        raise broken(f"must be in [{low}, {high}]")
    return int(value)


def _dumped(model: int | SonarModel) -> object:
    return model.model_dump() if isinstance(model, SonarModel) else model


def _given_figures(value: object) -> object:
    return value.given() if isinstance(value, SonarNoise) else value


class SonarSetup(Model):
    """A vehicle's multibeam model, and how it is simulated.

    model: an EM 2040 by its number on the wire (1: 600 kHz single, 2: 700 kHz single, 3: 600 kHz dual, 4: 700 kHz dual
    swath); or a packaged model's name, or the path of its YAML file, which is read into a SonarModel. frequency_hz:
    frequency, for a model with several. range_max_m: the operator's setting, for a model with a larger range; the
    travel time over this range then limits the ping rate. receivers: 2 ("dual RX") for a model that can have two, with
    a wider fan and twice the beams; by default the model's number. mode: `geometry`, one exact ray for each beam, or
    `physics`, in which ranges, errors and gaps follow from acoustics. bending: in physics mode, rays follow the water's
    sound-speed profile. rays_per_beam: number of rays for each footprint, in physics mode. multipath: in physics mode,
    whether echoes by more than one bounce are received; by default the model's. water_column: in physics mode, whether
    every ping contains the water column, and whether a channel provides it. tilt_rate_deg_s: tilt rate of the head,
    overriding the model's. gain_db: gain of the receiver's display, added to every intensity. noise: values for physics
    mode that override the model's.
    tilt_deg: initial tilt, positive nose down, as scanPos on the wire. on: a sonar that is off tilts, but receives no
    echoes.
    """

    model: Annotated[
        int | SonarModel,
        PlainValidator(_sonar_model, json_schema_input_type=SonarNumber | SonarName | SonarModel),
        PlainSerializer(_dumped),
    ] = 2
    frequency_hz: FrequencyHz | None = None
    range_max_m: Annotated[float, InRange(0.1, 12_000, "m")] | None = None
    receivers: Receivers | None = None
    mode: SonarMode = "geometry"
    bending: bool = False
    rays_per_beam: Annotated[int, InRange(4, 64)] = 8
    multipath: StrictBool | None = None
    water_column: StrictBool = False
    tilt_rate_deg_s: Annotated[float, InRange(0.01, 1000, "deg/s")] | None = None
    gain_db: Annotated[float, InRange(-100, 100, "dB")] = 0.0
    noise: Annotated[SonarNoiseChanges, BeforeValidator(_given_figures)] | None = None
    tilt_deg: NoseDown = 0.0
    on: StrictBool = True

    @model_validator(mode="after")
    def _fits_its_model(self) -> SonarSetup:
        for key in ("bending", "multipath", "water_column"):
            if getattr(self, key) and self.mode != "physics":
                raise broken("is for `mode: physics` only", at=(key,), value=True)
        try:
            loaded = self.loaded
            if self.mode == "physics":
                loaded.acoustic_band(self.frequency_hz)
            else:
                loaded.band(self.frequency_hz)
        except ScenarioError:
            raise
        except ValueError as error:
            raise broken(str(error)) from None
        if self.range_max_m is not None and loaded.wire_number is not None:
            fixed = f"must be left out for {self.loaded.name}, whose range is fixed"
            rule = f"{fixed}; it is for models such as em2040-04 and em2040-07"
            raise broken(rule, at=("range_max_m",), value=self.range_max_m, unit="m")
        return self

    @property
    def loaded(self) -> SonarModel:
        """The model with the selected receivers, range, tilt rate and noise. Raises ValueError."""
        model = self.model if isinstance(self.model, SonarModel) else load_sonar(self.model)
        if self.receivers is not None:
            model = model.with_receivers(self.receivers, self.frequency_hz)
        own: dict[str, object] = {}
        if self.multipath is not None:
            own["multipath"] = self.multipath
        if self.tilt_rate_deg_s is not None:
            own["tilt_rate_deg_s"] = self.tilt_rate_deg_s
        if self.noise is not None:
            own["noise"] = self.noise.of(model.noise)
        model = model.model_copy(update=own) if own else model
        return model if self.range_max_m is None else model.within(self.range_max_m)

    @property
    def title(self) -> str:
        """The wire number or name of the model, with the receivers and the frequency if specified."""
        name = self.model.name if isinstance(self.model, SonarModel) else str(self.model)
        name = f"{name} with {self.receivers} receivers" if self.receivers is not None else name
        return name if self.frequency_hz is None else f"{name} at {self.frequency_hz / 1e3:g} kHz"
