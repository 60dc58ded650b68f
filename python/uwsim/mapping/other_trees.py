"""Trees of OctoMap with more than occupancy: ColorOcTree and OcTreeStamped, whose files are read as an OcTree.

Source: OctoMap 1.9.7, AbstractOcTree::write and the nodes' writeData: a header of lines, then the nodes in depth-first
order, each of a fixed size: log-odds, what the type adds, a byte of children. OcTreeStamped writes no time. A .bt has
the same nodes for all types.
"""

from __future__ import annotations

import os
import re
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

HEADER_BYTES = 65_536
PLAIN = np.dtype([("log_odds", "<f4"), ("children", "u1")])
NODES = {
    b"ColorOcTree": (
        np.dtype([("log_odds", "<f4"), ("colour", "u1", 3), ("children", "u1")]),
        "its colours are left out",
    ),
    b"OcTreeStamped": (PLAIN, "its times are not in the file"),
}
"""Layout of a node, and a note, by the type in the header."""
TITLE, BINARY_TITLE = b"# Octomap OcTree file", b"# Octomap OcTree binary file"


@contextmanager
def as_octree(path: str | os.PathLike[str]) -> Iterator[str]:
    """Yield the path of a map that is an OcTree: the file itself, or a temporary one with its occupancy.

    Warns of what is left out. Raises ValueError if a tree of another type is cut short, and OSError.
    """
    named = Path(os.fspath(path))
    head = b""
    if named.is_file():
        with named.open("rb") as file:
            head = file.read(HEADER_BYTES)
    found = re.search(rb"^id (\w+)$", head.split(b"\ndata\n")[0], re.MULTILINE)
    if not head.startswith((TITLE, BINARY_TITLE)) or found is None or found[1] not in NODES:
        yield os.fspath(path)
        return
    layout, note = NODES[found[1]]
    header, _, body = named.read_bytes().partition(b"\ndata\n")
    if head.startswith(TITLE):
        if rest := len(body) % layout.itemsize:
            raise ValueError(f"map '{named}': cut short: {rest} bytes follow its last node")
        nodes = np.frombuffer(body, layout)
        plain = np.empty(len(nodes), PLAIN)
        plain["log_odds"], plain["children"] = nodes["log_odds"], nodes["children"]
        body = plain.tobytes()
    kind = found[1].decode()
    warnings.warn(f"map '{named}': is a {kind}, read as occupancy: {note}", stacklevel=3)
    with tempfile.NamedTemporaryFile(suffix=".ot") as made:
        made.write(header.replace(b"id " + found[1], b"id OcTree") + b"\ndata\n" + body)
        made.flush()
        try:
            yield made.name
        except ValueError as error:
            raise ValueError(str(error).replace(made.name, str(named))) from None
