"""Checks that mesh files are complete, since trimesh silently reads as much as it can of a damaged file."""

from __future__ import annotations

import re

from uwsim.base.caught_warnings import warn_if_cut_short

MAX_HEADER = 65_536
TEXT_SUFFIXES = (".obj", ".off", ".ply")
PLY_HEADER = re.compile(
    rb"ply[ \t]*\r?\nformat[ \t]+(ascii|binary_\w+)[^\n]*\n"
    rb"((?:(?:comment|obj_info|element|property)\b[^\n]*\n)*)end_header\b",
    re.IGNORECASE,
)
PLY_ELEMENT = re.compile(rb"^element[ \t]+(\w+)[ \t]+(\d+)", re.IGNORECASE | re.MULTILINE)
STL_SOLID, STL_END = re.compile(rb"\s*solid\b.*\n"), re.compile(rb"\s*endsolid\b.*")
STL_FACET = re.compile(
    rb"\s*facet[ \t]+normal(?:[ \t]+\S+){3}\s+outer[ \t]+loop\s"
    rb"(?:\s*vertex(?:[ \t]+\S+){3}[ \t\r]*\n){3}\s*endloop\s+endfacet\b"
)


def require_whole(name: str, suffix: str, content: bytes, triangles: int) -> None:
    """Raise ValueError if triangles are missing; warn if the last line of a text file has no line break.

    name: the file, for messages. suffix: one of TEXT_SUFFIXES; the glTF reader has its own check.
    """
    head = content[:MAX_HEADER]
    if suffix == ".off" and re.search(rb"[^\t\n\r -~]", re.sub(rb"#[^\n]*", b"", content)):
        raise ValueError("holds other characters than numbers")  # trimesh would guess an encoding from the whole file
    if suffix == ".off" and re.match(rb"(?:\s|#[^\n]*\n)*C?OFF\b", content) is None:
        raise ValueError("does not begin with OFF")  # trimesh would search for it in the whole file
    is_binary, faces = _ply_header(head) if suffix == ".ply" else (False, _announced_faces(suffix, head))
    if triangles < faces:
        raise ValueError(f"announces {faces} faces, but only {triangles} triangles follow: is the file cut short?")
    if not is_binary:
        warn_if_cut_short(name, content)


def require_whole_stl(name: str, text: bytes) -> None:
    """Raise ValueError unless a text STL consists entirely of solids made of facets; warn like require_whole."""
    warn_if_cut_short(name, text)  # another solid may be missing
    text, at = text.lower(), 0
    while begins := STL_SOLID.match(text, at):
        at = begins.end()
        while facet := STL_FACET.match(text, at):
            at = facet.end()
        if (ends := STL_END.match(text, at)) is None:
            break
        at = ends.end()
    rest = text[at:].lstrip()
    if b"endsolid" in rest or (rest and not begins):
        line = 1 + text.count(b"\n", 0, len(text) - len(rest))
        raise ValueError(f"line {line}: expected {'a facet with three vertices' if begins else 'solid'}")
    if begins or not at:
        raise ValueError("breaks off before its endsolid")


def _ply_header(head: bytes) -> tuple[bool, int]:
    """Return, from a PLY header, whether the file is binary and the number of faces declared. Raises ValueError.

    trimesh ignores unknown lines, and uses the last of several elements with the same name.
    """
    header = PLY_HEADER.match(head)
    if header is None:
        raise ValueError("its header is not that of a PLY file: format, comments, elements and properties")
    elements = PLY_ELEMENT.findall(header[2])
    counts = {name.lower(): int(count) for name, count in elements}
    if len(counts) < len(elements):
        raise ValueError("names one element twice")
    return header[1].lower().startswith(b"binary"), counts.get(b"face", 0)


def _announced_faces(suffix: str, head: bytes) -> int:
    """Return the number of faces declared in a header, or 0 if none are declared."""
    words = re.sub(rb"#[^\n]*", b"", head).split(maxsplit=3) if suffix == ".off" else []
    return int(words[2]) if len(words) > 2 and words[2].isdigit() else 0
