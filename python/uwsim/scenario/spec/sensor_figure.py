"""A key of a kind of sensor: its width, default, range and unit, in the core and in Python alike."""

from typing import Protocol


class SensorFigure(Protocol):
    """A key of one kind of sensor; see _core.Parameter."""

    @property
    def width(self) -> int:
        """The number of values."""

    @property
    def by_default(self) -> float:
        """The default of each value; NaN if the key is required."""

    @property
    def low(self) -> float:
        """The smallest value."""

    @property
    def high(self) -> float:
        """The largest value."""

    @property
    def unit(self) -> str:
        """The unit."""

    @property
    def type(self) -> str:
        """One of "number", "whole number" and "flag"."""

    @property
    def meaning(self) -> str:
        """A description."""
