"""Whether a mesh file is whole: trimesh reads PLY and OFF as far as they go, even if their header announces more."""

from __future__ import annotations

import re

from uwsim.cut_short import warn_if_cut_short

MAX_HEADER = 65_536
TEXT_SUFFIXES = (".obj", ".off", ".ply")


def require_whole(name: str, suffix: str, content: bytes, triangles: int) -> None:
    """Raise ValueError if fewer triangles were read than there are faces; warn if the last line of a text has no end.

    name: what messages call the file. suffix: of TEXT_SUFFIXES. Of STL and glTF the readers find it out themselves.
    """
    head = content[:MAX_HEADER]
    if suffix == ".off" and not re.sub(rb"#[^\n]*", b"", content).isascii():
        raise ValueError("holds other characters than numbers")  # trimesh guesses an encoding from all of the file
    faces = _announced_faces(suffix, head)
    if triangles < faces:
        raise ValueError(f"announces {faces} faces, but only {triangles} triangles follow: is the file cut short?")
    if suffix != ".ply" or re.search(rb"^format\s+binary", head, re.MULTILINE) is None:
        warn_if_cut_short(name, content)


def _announced_faces(suffix: str, head: bytes) -> int:
    """Return the number of faces that a header announces; 0 if it announces none."""
    if suffix == ".ply":
        found = re.search(rb"^element\s+face\s+(\d+)", head, re.MULTILINE)
        return int(found[1]) if found else 0
    words = re.sub(rb"#[^\n]*", b"", head).split(maxsplit=3) if suffix == ".off" else []
    return int(words[2]) if len(words) > 2 and words[2].isdigit() else 0
