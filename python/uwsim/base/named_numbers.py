"""Named numbers of one option, such as --offsets roll=0.5,latency=0.02."""

from __future__ import annotations

from collections.abc import Mapping


def named_numbers(option: str, text: str, limits: Mapping[str, tuple[float, float, str]]) -> dict[str, float]:
    """Return the numbers in a text by name. limits: lowest, highest and unit by name.

    Raises ValueError, which names the option and the key, for an unknown or repeated name, or a number that is out of
    its limits.
    """
    values: dict[str, float] = {}
    for part in text.split(","):
        name, equals, number = (each.strip() for each in part.partition("="))
        if not equals or name not in limits or name in values:
            names, example = ", ".join(limits), next(iter(limits))
            raise ValueError(f"{option} '{part.strip()}': must be one of {names}, each once, as {example}=0.5")
        low, high, unit = limits[name]
        try:
            values[name] = float(number)
        except ValueError:
            raise ValueError(f"{option} {name}={number}: must be a number in {unit}") from None
        if not low <= values[name] <= high:  # false for nan, too
            raise ValueError(f"{option} {name}={number} {unit}: must be in [{low:g}, {high:g}] {unit}")
    return values
