"""Note: what became of a part of a file that was read."""

from dataclasses import dataclass, field
from typing import Literal

Kind = Literal["", "read", "known", "missing", "left out", "assumed", "refused", "arguments", "topic"]
Grade = Literal["", "motion", "senses", "looks"]


@dataclass(frozen=True)
class Note:
    """As text, it is the printed line. kind: empty for advice. grade: of a loss, what it changes; not compared."""

    kind: Kind
    text: str
    grade: Grade = field(default="", compare=False)

    def __str__(self) -> str:
        return ": ".join(filter(None, (self.grade, self.kind, self.text)))
