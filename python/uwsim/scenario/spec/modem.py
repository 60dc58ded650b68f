"""A modem, or another connection between station and vehicle, as read from its YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import InRange, Model, Name, broken

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
