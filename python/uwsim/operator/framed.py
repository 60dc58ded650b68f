"""Framed: a page of this machine that a script, prompt or notebook opens and closes."""

from __future__ import annotations

import os
import sys
import webbrowser
from html import escape
from types import TracebackType
from typing import Self

LOCAL_PAGES = "http://localhost:* http://127.0.0.1:*"
"""Pages that may show the page in a frame: those served from this machine, such as Jupyter's."""
HEIGHT_PX = 600


class Framed:
    """A page at `url`; close its server with `close`, or use it as a context manager. Notebooks show it in a frame."""

    url: str

    def close(self) -> None:
        """Close the page's server."""
        raise NotImplementedError

    def open(self, browser: bool | None) -> Self:
        """Open a browser window; if None, only on a desktop and outside notebooks."""
        if browser if browser is not None else (has_display() and "ipykernel" not in sys.modules):
            webbrowser.open(self.url)
        return self

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """Return the page in a frame, for notebooks on this machine."""
        size = f'width="100%" height="{HEIGHT_PX}" style="border: 0"'
        return f'<iframe src="{escape(self.url)}" title="uwsim" {size}></iframe>'


def has_display() -> bool:
    """Return whether a browser would open a window rather than take over the terminal."""
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
