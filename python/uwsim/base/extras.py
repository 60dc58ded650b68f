"""Checks for optional dependencies, which a plain `pip install uwsim` does not install."""

from __future__ import annotations

from importlib.util import find_spec


class MissingExtraError(ImportError, ValueError):
    """Raised if a package for an optional feature is missing. Also a ValueError, since the user can fix it."""


def need_extra(module: str, extra: str, what: str) -> None:
    """Raise MissingExtraError, stating the command that installs the module, if it cannot be found."""
    if find_spec(module) is None:
        raise MissingExtraError(f"{what} needs '{module}', which is not installed: pip install 'uwsim[{extra}]'")
