"""A scenario's link between station and vehicles, and its modems, which have their own files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import AssetName, InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.water_parts import LINK_MOST_M_S

Access = Literal["aloha", "tdma"]
SLOWEST_SOUND_M_S = 1400.0  # fresh water at 0 deg C: 1402 m/s

NEEDED = ("bit_rate_bit_s", "frequency_hz", "bandwidth_hz", "source_level_db")


class ModemModel(Model):
    """A connection between station and vehicle.

    kind: `none` (messages are delivered immediately), `cable` (a rate and a latency), `ideal` (only the travel time of
    sound, as in the paper) or `modem`, which has all parameters. Levels in dB re 1 uPa (at 1 m). bit_rate_bit_s: rate
    at which a packet's bits, including the header, are sent. latency_s: latency of a cable. header_bytes: size of each
    packet's header. packet_bytes: largest payload of a packet; longer messages take several. preamble_s: duration of
    the preamble of each packet. frequency_hz, bandwidth_hz: centre and width of the band. source_level_db: level of the
    transmitter, re 1 uPa at 1 m. modulation: determines the bit error rate for a signal-to-noise ratio. coding_gain_db:
    gain from error correction. receiver_noise_db_hz: noise from the vehicle and the electronics. fading: whether there
    is Rayleigh fading. multipath_window_s: guard time; echoes that follow the first arrival within this time add to the
    signal. Later echoes disturb the next symbol increasingly; after another symbol_s they are only noise.
    speed_max_m_s: closing speed beyond which nothing is received (Doppler). range_max_m: the range for which TDMA
    reserves travel time. slot_s: duration of a turn in TDMA. backoff_s: longest random wait in ALOHA. access: `aloha`,
    a packet is sent after a random wait of up to backoff_s, or `tdma`, the station and the vehicles take turns of
    slot_s, each followed by the travel time over range_max_m. queue_bytes: largest size of the queue of messages to be
    sent. retransmissions: how many times a message is sent again, whole, if no acknowledgement has arrived after the
    longest wait for a turn and twice the travel time over range_max_m; 0: there are no acknowledgements.
    acknowledgement_bytes: payload of the packet that acknowledges a message, in addition to the header.
    """

    name: Name
    description: str = ""
    kind: Literal["none", "cable", "ideal", "modem"] = "modem"
    bit_rate_bit_s: Annotated[float, InRange(1, 1e10, "bit/s")] | None = None
    latency_s: Annotated[float, InRange(0, 60, "s")] = 0.0
    packet_bytes: Annotated[int, InRange(1, 1_000_000, "bytes")] = 1024
    header_bytes: Annotated[int, InRange(0, 10_000, "bytes")] = 0
    preamble_s: Annotated[float, InRange(0, 60, "s")] = 0.0
    frequency_hz: Annotated[float, InRange(100, 1e6, "Hz")] | None = None
    bandwidth_hz: Annotated[float, InRange(1, 1e6, "Hz")] | None = None
    source_level_db: Annotated[float, InRange(50, 250, "dB")] | None = None
    receiver_noise_db_hz: Annotated[float, InRange(-100, 200, "dB")] = -100.0
    modulation: Literal["psk", "fsk"] = "psk"
    fading: bool = False
    coding_gain_db: Annotated[float, InRange(0, 60, "dB")] = 0.0
    multipath_window_s: Annotated[float, InRange(0, 10, "s")] = 0.01
    symbol_s: Annotated[float, InRange(0, 10, "s")] = 0.0
    speed_max_m_s: Annotated[float, InRange(0, 100, "m/s")] = 5.0
    range_max_m: Annotated[float, InRange(1, 100_000, "m")] = 1000.0
    access: Access = "tdma"
    slot_s: Annotated[float, InRange(0.001, 600, "s")] = 1.0
    backoff_s: Annotated[float, InRange(0, 600, "s")] = 1.0
    queue_bytes: Annotated[int, InRange(1, 1_000_000_000, "bytes")] = 1_000_000
    retransmissions: Annotated[int, InRange(0, 100)] = 0
    acknowledgement_bytes: Annotated[int, InRange(0, 10_000, "bytes")] = 0

    @model_validator(mode="after")
    def _is_whole(self) -> ModemModel:
        allowed = {"none": (), "ideal": (), "cable": CABLE}.get(self.kind)
        if allowed is not None:
            for key in sorted(type(self).model_fields.keys() - {"name", "description", "kind", *allowed}):
                if getattr(self, key) != type(self).model_fields[key].default:
                    raise broken(f"has no effect on a link of kind '{self.kind}'", at=(key,))
            return self
        for key in NEEDED:
            if getattr(self, key) is None:
                raise broken("missing: a modem needs it", at=(key,))
        if self.latency_s > 0:
            raise broken("has no effect on a modem, whose delay is the sound's", at=("latency_s",))
        if self.bandwidth_hz > 2 * self.frequency_hz:  # type: ignore[operator]
            rule = f"must be at most twice the frequency, {2 * self.frequency_hz:g} Hz"  # type: ignore[operator]
            raise broken(rule, at=("bandwidth_hz",), value=self.bandwidth_hz, unit="Hz")
        if self.acknowledgement_bytes > self.packet_bytes:
            rule = f"must fit into a packet, {self.packet_bytes} bytes"
            raise broken(rule, at=("acknowledgement_bytes",), value=self.acknowledgement_bytes, unit="bytes")
        if self.access == "tdma" and self.slot_s < self.packet_s():
            rule = f"must hold a full packet, {self.packet_s():.3g} s"
            raise broken(rule, at=("slot_s",), value=self.slot_s, unit="s")
        return self

    @property
    def guard_s(self) -> float:
        """The time in each TDMA slot that is reserved for the propagation of sound, in seconds."""
        return self.range_max_m / SLOWEST_SOUND_M_S

    def packet_s(self, payload_bytes: int | None = None) -> float:
        """Return the duration of a packet, by default a full one, in seconds."""
        if self.bit_rate_bit_s is None:
            return 0.0
        size = self.packet_bytes if payload_bytes is None else payload_bytes
        return self.preamble_s + 8.0 * (size + self.header_bytes) / self.bit_rate_bit_s


CABLE = ("bit_rate_bit_s", "latency_s", "packet_bytes", "header_bytes", "queue_bytes")


def load_modem(source: str | Path, folder: Path | None = None) -> ModemModel:
    """Load a modem from a packaged name ("micromodem") or the path of its YAML file. Raises ScenarioError."""
    return read_spec(ModemModel, source, "modems", folder)


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
