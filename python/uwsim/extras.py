"""Optional parts, which `pip install uwsim` leaves out."""

from __future__ import annotations

from importlib.util import find_spec


class MissingExtraError(ImportError, ValueError):
    """A package is missing that only an optional part needs. A ValueError, since the user can mend it."""


def need_extra(module: str, extra: str, what: str) -> None:
    """Raise MissingExtraError, which names the command to run, unless a module can be imported."""
    if find_spec(module) is None:
        raise MissingExtraError(f"{what} needs '{module}', which is not installed: pip install 'uwsim[{extra}]'")
