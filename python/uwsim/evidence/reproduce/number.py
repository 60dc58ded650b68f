"""A number of a figure, from their files and from ours."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Number:
    """A figure's number from their files and from ours. claim: what must hold of them; held: whether it does."""

    figure: int
    quantity: str
    unit: str
    theirs: float | None
    ours: float | None
    claim: str
    held: bool


def shown(value: float | None, unit: str) -> str:
    """Return a number with its unit."""
    return "none" if value is None else f"{value:.4g} {unit}".strip()
