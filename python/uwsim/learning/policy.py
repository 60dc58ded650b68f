"""A policy small enough to read: each action is a linear function of the observation, clipped to [-1, 1]."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.short_repr import ShortRepr
from uwsim.base.texts.json_text import json_value
from uwsim.base.texts.text_file import require_regular
from uwsim.scenario.read.assets import assets_folder

Floats = NDArray[np.float64]


class Policy(Protocol):
    """Maps observations (n, width) to actions (n, axes)."""

    def __call__(self, observation: Any) -> Floats:
        """Return actions."""


@dataclass(frozen=True, eq=False, repr=False)
class LinearPolicy(ShortRepr):
    """A linear policy of observations in their own units (`normalise=False`).

    weights: (axes, width). bias: (axes,). about: the origin of the policy.
    """

    weights: Floats
    bias: Floats
    about: dict[str, Any] = field(default_factory=dict)

    def __call__(self, observation: Any) -> Floats:
        """Return actions (n, axes) for observations (n, width), or (axes,) for a single observation."""
        return np.clip(np.asarray(observation, np.float64) @ self.weights.T + self.bias, -1.0, 1.0)

    def save(self, path: Path) -> None:
        """Write the policy as JSON, rounded to six digits."""
        rows = {"weights": _rounded(self.weights), "bias": _rounded(self.bias)}
        write_atomically(path, (json.dumps({**self.about, **rows}) + "\n").encode())

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """Return a packaged policy, such as "station_keeping", or a policy from a file.

        Raises ValueError if the file contains no valid policy, OSError if it cannot be read.
        """
        packaged = assets_folder() / "learning" / "policies" / f"{source}.json"
        path = packaged if packaged.is_file() else Path(source)
        about = json_value(require_regular(path).read_bytes(), f"policy '{path}'")
        try:
            weights, bias = (np.array(about.pop(key), np.float64) for key in ("weights", "bias"))
        except (KeyError, TypeError, ValueError, AttributeError):
            raise ValueError(f"policy '{path}': must have weights (axes, width) and bias (axes,)") from None
        if weights.ndim != 2 or bias.shape != weights.shape[:1] or not np.isfinite(weights).all():
            raise ValueError(f"policy '{path}': weights {weights.shape} and bias {bias.shape} do not fit")
        return cls(weights, bias, about)


def _rounded(values: Floats) -> list[Any]:
    return [[float(f"{v:.6g}") for v in row] for row in np.atleast_2d(values)] if values.ndim > 1 else [
        float(f"{v:.6g}") for v in values
    ]  # fmt: skip
