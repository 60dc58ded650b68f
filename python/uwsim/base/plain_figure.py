"""Figures whose texts are shown as they are written: matplotlib reads no text with `$` as mathematics or as TeX."""

from __future__ import annotations

from typing import Any

from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import Formatter, LogFormatter, ScalarFormatter


class PlainFigure(Figure):
    """A matplotlib Figure that shows all its texts as they are written.

    All of uwsim's figures are of this class, because titles and names in them come from files. The settings of
    matplotlib (rcParams), which are the user's, stay as they are.
    """

    def draw(self, renderer: Any) -> None:
        """See Figure."""
        show_as_written(self)
        super().draw(renderer)

    def get_tightbbox(self, *args: Any, **options: Any) -> Any:
        """See Figure."""
        show_as_written(self)
        return super().get_tightbbox(*args, **options)

    def tight_layout(self, **options: Any) -> None:
        """See Figure."""
        show_as_written(self)
        super().tight_layout(**options)


def show_as_written(figure: Figure) -> None:
    """Switch off TeX, and the parsing of all texts except numbers on axes, which matplotlib itself writes."""
    numbers: set[Text] = set()
    for axis in figure.findobj(Axis):
        assert isinstance(axis, Axis)
        if _writes_numbers(axis.get_major_formatter()):
            numbers.add(axis.offsetText)
            numbers |= {label for tick in axis.get_major_ticks() for label in (tick.label1, tick.label2)}
        if _writes_numbers(axis.get_minor_formatter()):
            numbers |= {label for tick in axis.get_minor_ticks() for label in (tick.label1, tick.label2)}
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        text.set_usetex(False)
        if text not in numbers:
            text.set_parse_math(False)


def _writes_numbers(formatter: Formatter) -> bool:
    return isinstance(formatter, ScalarFormatter | LogFormatter)
