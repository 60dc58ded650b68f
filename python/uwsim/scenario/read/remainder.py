"""The valid remainder of the values in a file: mistakes are left out so that the rest can still be checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from uwsim.base.texts.yaml_document import Key

Path = tuple[Key, ...]


class LeftOut:
    """Positions in the file of what was removed, as sets, since there may be many thousands.

    places: the positions. around: they and all that contain them. below: pairs of what contains one and a key, as text,
    that leads from there to it.
    """

    def __init__(self) -> None:
        self.places: set[Path] = set()
        self.around: set[Path] = set()
        self.below: set[tuple[Path, str]] = set()

    def add(self, path: Path) -> None:
        """Add a position."""
        self.places.add(path)
        for length in range(len(path)):
            self.around.add(path[:length])
            self.below.update((path[:length], str(key)) for key in path[length:])
        self.around.add(path)


class Remainder:
    """A copy of values from which parts were removed; it maps positions in the copy to positions in the file.

    values: dicts and lists are copied, models and plain values are not.
    """

    def __init__(self, values: Any) -> None:
        self.left_out = LeftOut()
        self._positions: dict[int, list[int]] = {}  # original indices of the remaining items, keyed by list id
        self._spelt: dict[tuple[int, Key], Key] = {}  # the file's spelling of a key, by mapping id
        self.values = self._copy(values)

    def _copy(self, value: Any) -> Any:
        if isinstance(value, Mapping):
            return {key: self._copy(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            copy = [self._copy(item) for item in value]
            self._positions[id(copy)] = list(range(len(copy)))
            return copy
        return value

    def in_file(self, path: Sequence[Key]) -> Path:
        """Return the position in the file for a position in `values`."""
        node: Any = self.values
        found: list[Key] = []
        for key in path:
            positions = self._positions.get(id(node), ())
            if isinstance(key, int) and key < len(positions):
                found.append(positions[key])
            else:
                found.append(self._spelt.get((id(node), key), key))
            try:
                node = node[key]
            except (KeyError, IndexError, TypeError):
                node = None
        return tuple(found)

    def has(self, path: Path) -> bool:
        """Return whether the key exists."""
        node = self._at(path[:-1])
        return isinstance(node, dict) and path[-1] in node

    def rename(self, path: Path, key: str) -> bool:
        """Rename a key; return False if the new name is already in use."""
        node = self._at(path[:-1])
        if not isinstance(node, dict) or key in node or path[-1] not in node:
            return False
        self._spelt[id(node), key] = path[-1]
        node[key] = node.pop(path[-1])
        return True

    def leave_out(self, path: Path) -> Path | None:
        """Remove a key, a list item that is a mapping, or its nearest existing ancestor.

        Return the position removed, or None if nothing would remain.
        """
        while path:
            node, key = self._at(path[:-1]), path[-1]
            if isinstance(node, dict) and key in node:
                self.left_out.add(self.in_file(path))
                del node[key]
                return path
            if isinstance(node, list) and isinstance(key, int) and key < len(node) and isinstance(node[key], dict):
                self.left_out.add(self.in_file(path))
                del node[key]
                del self._positions[id(node)][key]
                return path
            path = path[:-1]
        return None

    def _at(self, path: Sequence[Key]) -> Any:
        node: Any = self.values
        for key in path:
            try:
                node = node[key]
            except (KeyError, IndexError, TypeError):
                return None
        return node
