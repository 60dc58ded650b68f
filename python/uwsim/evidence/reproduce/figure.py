"""Figure: a reproduced figure from the paper, with its title and values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

PAPER = "Development of an Underwater Simulator using Unity3D and Robot Operating System"


@dataclass(frozen=True)
class Figure:
    """One of the figures in the paper.

    number: its number in the paper, where the caption names the same subject. differs: a sentence on how this figure
    differs from the paper's. columns, rows: the table behind the picture. values: single values.
    """

    number: int
    title: str
    caption: str
    differs: str
    values: dict[str, Any] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    rows: list[tuple[Any, ...]] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The name of the figure files, without suffix."""
        return f"fig{self.number:02d}"
