"""A scenario's link between station and vehicles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.spec.fields import AssetName, InRange, Model, Point3, broken
from uwsim.scenario.spec.modem import Access, ModemModel, load_modem
from uwsim.scenario.spec.wind import LINK_MOST_M_S

ModemName = Annotated[str, AssetName("modems")]
Bottom = Literal["clay", "silt", "sand", "gravel"]
BOTTOMS: dict[str, tuple[float, float, float]] = {
    "clay": (1.5, 1.00, 0.2),
    "silt": (1.7, 1.05, 1.0),
    "sand": (1.9, 1.1, 0.8),
    "gravel": (2.0, 1.2, 0.6),
}
"""Density and speed of sound relative to water, attenuation [dB per wavelength]: Jensen, Kuperman, Porter and Schmidt
2011, "Computational Ocean Acoustics", table 1.3, as in the Under Sea Modeling Library (reflect_loss_rayleigh.cc)."""


class LinkFault(Model):
    """A period in which packets are lost, regardless of conditions.

    from_s, until_s: simulated time. loss: fraction of packets lost; 1 is a blackout.
    """

    from_s: Annotated[float, InRange(0, 1e9, "s")]
    until_s: Annotated[float, InRange(0, 1e9, "s")]
    loss: Annotated[float, InRange(1e-6, 1)] = 1.0

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> LinkFault:
        if self.until_s <= self.from_s:
            raise broken(f"must be after from_s, {self.from_s:g} s", at=("until_s",), value=self.until_s, unit="s")
        return self


def _modem(value: object, info: ValidationInfo) -> object:
    if isinstance(value, str | Path):
        return load_modem(value, folder=(info.context or {}).get("folder"))
    return value


class LinkSetup(Model):
    """The link between the station and the vehicles. In a scenario, a modem's name alone suffices.

    modem: the name of a packaged modem or the path of its YAML file, which is read into a ModemModel. access,
    retransmissions: override the modem's access protocol and number of retransmissions.
    station_transducer_m: position of the transducer in the station's frame, under water; by default at the station's
    place 3 m below the surface, or half-way to the bed where that is shallower; for a carried station, 3 m below its
    carrier's origin. A vehicle's transducer is at its origin.
    wind_m_s, shipping: sources of ambient noise, the wind by default that of the scenario's `wind`, if there is one;
    shipping 0: none, 1: heavy. bottom: the material that reflects sound
    at the bed. carries: patterns of the channels that use the link, by default all that can. repeats: number of
    additional copies of each message, by channel pattern, sent whether or not the first arrives; a service's command is
    `command/NAME`. faults: scheduled losses.
    """

    modem: Annotated[ModemModel, BeforeValidator(_modem, json_schema_input_type=ModemName | ModemModel)]
    access: Access | None = None
    retransmissions: Annotated[int, InRange(0, 100)] | None = None
    station_transducer_m: Point3 | None = None
    wind_m_s: Annotated[float, InRange(0, LINK_MOST_M_S, "m/s")] = 5.0
    shipping: Annotated[float, InRange(0, 1)] = 0.5
    bottom: Bottom = "silt"
    carries: Annotated[tuple[str, ...], Field(min_length=1, max_length=1000)] = ("*",)
    repeats: Annotated[dict[str, Annotated[int, InRange(1, 10)]], Field(max_length=1000)] = Field(default_factory=dict)
    faults: Annotated[tuple[LinkFault, ...], Field(max_length=1000)] = ()

    @model_validator(mode="after")
    def _fits_its_modem(self) -> LinkSetup:
        for key in ("access", "retransmissions"):
            if getattr(self, key) is not None and self.modem.kind != "modem":
                raise broken(f"has no effect on a link of kind '{self.modem.kind}'", at=(key,))
        if self.access == "tdma" and self.modem.slot_s < self.modem.packet_s():
            rule = f"{self.modem.name}'s slot_s must hold a full packet, {self.modem.packet_s():.3g} s"
            raise broken(rule, at=("access",), value=self.access)
        return self


def _link_setup(value: Any) -> Any:
    """Return a setup for a modem's name or path; return anything else unchanged, to be validated."""
    return {"modem": value} if isinstance(value, str | Path) else value


LinkSpec = Annotated[LinkSetup, BeforeValidator(_link_setup, json_schema_input_type=ModemName | LinkSetup)]
"""A modem's name or path, or a setup."""
