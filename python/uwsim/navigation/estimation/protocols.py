"""The vehicle and sensor interfaces that navigation requires, as implemented by uwsim.Simulator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from uwsim import _core


class SamplesLike(Protocol):
    """A sensor's samples: stamps_ns, arrivals_ns (n,) uint64; readings (n, width); valid (n,) bool.

    The columns of `readings` are the fields of the sensor kind, side by side.
    """

    @property
    def stamps_ns(self) -> NDArray[Any]: ...
    @property
    def arrivals_ns(self) -> NDArray[Any]: ...
    @property
    def readings(self) -> NDArray[Any]: ...
    @property
    def valid(self) -> NDArray[Any]: ...


class StreamLike(Protocol):
    """A stream of future samples."""

    def take(self) -> SamplesLike:
        """Return the samples that have arrived since the previous call."""

    def close(self) -> None:
        """Stop the stream."""


class InstrumentLike(Protocol):
    """A sensor with its mount, parameters and errors."""

    @property
    def kind(self) -> str: ...
    @property
    def on(self) -> bool: ...
    @property
    def period_s(self) -> float: ...
    @property
    def latency_s(self) -> float: ...
    @property
    def spec(self) -> _core.SensorSpec: ...
    @property
    def time_ns(self) -> int:
        """The current time in nanoseconds."""

    def read(self) -> Any:
        """Return the latest value."""

    def stream(self, from_ns: int | None = None) -> StreamLike:
        """Return a stream of future samples measured at or after from_ns (default: after the current time)."""


class Instrumented(Protocol):
    """A vehicle with sensors, keyed by name."""

    @property
    def name(self) -> str: ...
    @property
    def sensors(self) -> Mapping[str, InstrumentLike]: ...
