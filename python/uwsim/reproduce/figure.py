"""A figure of the paper, made again: its picture's file, its title, and the values behind it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

PAPER = "Development of an Underwater Simulator using Unity3D and Robot Operating System"


@dataclass(frozen=True)
class Figure:
    """One of the paper's figures.

    number: in the paper. subject_known: whether the paper's figure of this number is known to show this; the others
    show, in its order, what else it describes. columns, rows: the table behind the picture; values: single ones.
    """

    number: int
    title: str
    caption: str
    subject_known: bool = False
    values: dict[str, Any] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    rows: list[tuple[Any, ...]] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The name of its files, without suffix."""
        return f"fig{self.number:02d}"
