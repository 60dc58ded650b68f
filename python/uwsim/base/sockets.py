"""Sockets: what uwsim and other packages register by entry points, in the groups `uwsim.bridges`, `uwsim.cli`, ...

uwsim's own entries stand in its pyproject.toml and go through the same functions as those of any other package;
docs/inside/extend.md lists the groups and what an entry of each must be. Nothing is imported before it is used.

The installed packages' lists are read here, in 3 ms: `importlib.metadata` takes 35, a tenth of `uwsim --help`.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, reduce
from importlib import import_module
from itertools import accumulate
from pathlib import Path
from typing import Any

from uwsim.base.named import did_you_mean

OWN = "uwsim"
"""The package whose entries come first, and cannot be replaced."""
PLANNERS = "uwsim.kinds.planner"
"""The group of planners: missions, functions of a vehicle and of arguments with defaults."""
SUFFIXES = (".dist-info", ".egg-info")

Adapt = Callable[[str, Any], Any]
"""Makes what a socket holds of an entry's name and object. Raises ValueError or TypeError for an unsuitable object."""


class SocketWarning(UserWarning):
    """Issued for an entry that cannot be used; uwsim goes on without it."""


class EntryError(ValueError):
    """Raised for an entry of another package that cannot be used, or of a part of uwsim that is not installed."""


@dataclass(frozen=True)
class Entry:
    """An entry of a package's list. value: where its object is, as MODULE:NAME."""

    name: str
    value: str
    package: str

    @property
    def is_own(self) -> bool:
        """True for an entry of uwsim."""
        return self.package == OWN

    def load(self) -> Any:
        """Import and return the object. Raises whatever its module raises.

        The packages around the module come first. Otherwise this thread may hold the module's lock and wait for its
        package's, while another thread, which imports the package, holds that and waits for the module's.
        """
        module, _, names = self.value.partition(":")
        *packages, found = accumulate(module.split("."), "{}.{}".format)
        for package in packages:
            import_module(package)
        return reduce(getattr, names.split("."), import_module(found))


@cache
def registered(group: str) -> Mapping[str, Entry]:
    """Return a group's entries by name: uwsim's own in the order of its pyproject.toml, then those of others by name.

    Of entries with the same name, uwsim's is kept, or the first package's by name. Warns with SocketWarning of others.
    Raises ValueError for a group of which uwsim's installation has no entry.
    """
    found: dict[str, Entry] = {}
    for entry in sorted(_installed().get(group, ()), key=_order):
        kept = found.setdefault(entry.name, entry)
        if kept is not entry:
            rule = f"the name is taken by {kept.package}"
            warnings.warn(f"{group}: '{entry.name}' of {entry.package}: {rule}", SocketWarning, stacklevel=2)
    if not any(entry.is_own for entry in found.values()):
        raise ValueError(f"{group}: uwsim's installation lists none: is it older than its sources? Install it again")
    return found


def is_offered(group: str) -> bool:
    """Return whether uwsim registers entries of its own in a group."""
    return any(entry.is_own for entry in _installed().get(group, ()))


def load(group: str, name: str, adapt: Adapt | None = None) -> Any:
    """Return the object that is registered under a name. Raises ValueError for an unknown name or a broken entry."""
    known = registered(group)
    if name not in known:
        raise ValueError(f"'{name}': must be one of {', '.join(known) or 'none'}{did_you_mean(name, known)}")
    return _loaded(group, known[name], adapt)


@cache
def load_all(group: str, adapt: Adapt | None = None, *, own: bool = False) -> Mapping[str, Any]:
    """Return all objects of a group by name. Warns, once, with SocketWarning where `load` raises EntryError.

    own: only uwsim's, without importing other packages.
    """
    found = {}
    for name, entry in registered(group).items():
        if own and not entry.is_own:
            continue
        try:
            found[name] = _loaded(group, entry, adapt)
        except EntryError as error:
            warnings.warn(str(error), SocketWarning, stacklevel=2)
    return found


def planner(name: str) -> Callable[..., Any]:
    """Return the planner that is registered under a name. Raises ValueError."""
    return load(PLANNERS, name, _function)  # type: ignore[no-any-return]


def _function(name: str, found: Any) -> Any:
    if not callable(found):
        raise TypeError(f"{type(found).__name__}: must be a function")
    return found


@contextmanager
def blaming(group: str, name: str, at: str, passes: tuple[type[Exception], ...] = ()) -> Iterator[None]:
    """Raise EntryError for what the code of another package's entry raises within the block.

    at: what it was asked for. passes: errors of the user, which the entry may raise.
    """
    try:
        yield
    except Exception as error:
        entry = registered(group).get(name)
        if entry is None or entry.is_own or isinstance(error, (EntryError, *passes)):
            raise
        raise EntryError(blamed(group, entry, error, at)) from error


def blamed(group: str, entry: Entry, error: BaseException, at: str = "cannot be used") -> str:
    """Return a line that names the package and the entry whose code raised an error. at: what it was asked for."""
    why = " ".join(f"{type(error).__name__}: {error}".split())
    return f"{group}: '{entry.name}' of {entry.package} ({entry.value}): {at}: {why}"


@cache
def _loaded(group: str, entry: Entry, adapt: Adapt | None) -> Any:
    try:
        found = entry.load()
        return found if adapt is None else adapt(entry.name, found)
    except (Exception, SystemExit) as error:  # a stranger's module may raise anything
        if entry.is_own and not _lacks_part(error):
            raise
        raise EntryError(blamed(group, entry, error)) from error


def _lacks_part(error: BaseException) -> bool:
    """Return whether a module of uwsim is not installed."""
    return isinstance(error, ModuleNotFoundError) and str(error.name).startswith(f"{OWN}.")


@cache
def _installed() -> dict[str, list[Entry]]:
    """Return all entries on sys.path by group; of a package that is there twice, those of the first."""
    groups: dict[str, list[Entry]] = {}
    seen = set()
    for info in _lists():
        package = info.parent.stem.partition("-")[0].replace("_", "-").lower()
        if package in seen:
            continue
        seen.add(package)
        try:
            text = info.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):  # most packages have none
            continue
        for group, name, value in _parsed(text):
            groups.setdefault(group, []).append(Entry(name, value, package))
    return groups


def _lists() -> Iterator[Path]:
    for folder in sys.path:
        try:
            infos = sorted(path for path in Path(folder).iterdir() if path.name.endswith(SUFFIXES))
        except OSError:  # such as the zip file of the standard library
            continue
        yield from (info / "entry_points.txt" for info in infos)


def _parsed(text: str) -> Iterator[tuple[str, str, str]]:
    """Yield group, name and value of each entry in uwsim's groups."""
    group = ""
    for line in map(str.strip, text.splitlines()):
        if line.startswith("["):
            group = line.strip("[] ")
        elif "=" in line and group.startswith(f"{OWN}.") and not line.startswith(("#", ";")):
            name, _, value = line.partition("=")
            yield group, name.strip(), value.partition("[")[0].strip()


def _order(entry: Entry) -> tuple[bool, str, str]:
    return (False, "", "") if entry.is_own else (True, entry.name, entry.package)
