"""A thruster's present state."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Thruster:
    """A thruster's state: its command in [-1, 1] and its still-water thrust, which follows with a lag."""

    command: float
    thrust_n: float
