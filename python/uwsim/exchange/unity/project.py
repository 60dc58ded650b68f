"""A checkout of a Unity project: which file an identifier means, and the documents of its scenes and prefabs."""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base.texts.text_file import require_regular
from uwsim.base.texts.yaml_document import yaml_document

GUID = re.compile(r"^guid: ([0-9a-f]{32})", re.MULTILINE)
DOCUMENT = re.compile(r"^--- !u!(\d+) &(-?\d+)( stripped)?\n(.*?)(?=^--- |\Z)", re.DOTALL | re.MULTILINE)
"""A document's class, its identifier in the file, whether it only refers to a prefab's, and its YAML."""
META_MAX = 10_000
COMPONENTS = re.compile(r"^  m_Component:\n(  - .*\n)*", re.MULTILINE)
"""An object's list of components, which also name it; old prefabs have numbers as keys in it."""
CLASSES = {1, 4, 21, 23, 33, 54, 224, 1001}
"""GameObject, Transform, Material, MeshRenderer, MeshFilter, Rigidbody, RectTransform, PrefabInstance (in Unity)."""


class Document(NamedTuple):
    """An object of a scene. kind: its class, such as Transform. values: its fields."""

    kind: str
    values: dict[str, Any]
    stripped: bool


class Project:
    """A project in a folder that contains Assets. Raises ValueError."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not (folder / "Assets").is_dir():
            raise ValueError(f"'{folder}': has no folder Assets: must be the checkout of a Unity project")

    @cached_property
    def _paths(self) -> dict[str, Path]:
        found = {}
        for meta in sorted((self.folder / "Assets").rglob("*.meta")):
            if not self._contains(meta) or not self._contains(meta.with_suffix("")) or not meta.is_file():
                continue
            with meta.open(errors="replace") as file:
                guid = GUID.search(file.read(META_MAX))
            if guid is not None:
                found[guid[1]] = meta.with_suffix("")
        return found

    def _contains(self, path: Path) -> bool:
        """Return whether a path is in the checkout, rather than a link to elsewhere."""
        return path.resolve().is_relative_to(self.folder.resolve())

    def path(self, guid: str) -> Path | None:
        """Return the file of an identifier, which may be missing, or None if no .meta file has it."""
        return self._paths.get(guid)

    def named(self, path: Path) -> str:
        """Return a path as seen from the project."""
        return path.relative_to(self.folder).as_posix()

    def documents(self, path: Path) -> dict[int, Document]:
        """Return the documents of a scene or prefab by their identifiers. Raises ValueError or OSError."""
        text = require_regular(path).read_text(errors="replace")
        if not text.startswith("%YAML"):
            raise ValueError(f"'{path}': must be YAML (Unity: Asset Serialization, Force Text)")
        found = {}
        for number, identifier, stripped, body in DOCUMENT.findall(text):
            if int(number) not in CLASSES:
                continue
            values = yaml_document(COMPONENTS.sub("", body), f"{path}, object {identifier}").values
            if len(values) != 1:
                raise ValueError(f"'{path}': object {identifier}: must have one class, not {len(values)}")
            ((kind, fields),) = values.items()
            found[int(identifier)] = Document(kind, fields, bool(stripped))
        return found
