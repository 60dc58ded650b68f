"""Optional dependencies, which `pip install uwsim` does not install."""

from __future__ import annotations

from importlib.util import find_spec


class MissingExtraError(ImportError, ValueError):
    """A package for an optional feature is missing. A ValueError, too: the user can fix it."""


def need_extra(module: str, extra: str, what: str) -> None:
    """Raise MissingExtraError, with the command that installs it, if a module cannot be imported."""
    if find_spec(module) is None:
        raise MissingExtraError(f"{what} needs '{module}', which is not installed: pip install 'uwsim[{extra}]'")
