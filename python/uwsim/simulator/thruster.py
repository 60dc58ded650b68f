"""The state of a thruster."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Thruster:
    """A thruster's state: its command in [-1, 1], and its still-water thrust, which follows the command with a lag.

    current_a: current drawn from the battery; 0 if the battery is modelled as a mission time.
    """

    command: float
    thrust_n: float
    current_a: float = 0.0
