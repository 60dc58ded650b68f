"""Trees of OctoMap with colours or times are read as occupancy, with a warning."""

from pathlib import Path

import numpy as np
import pytest

from uwsim.mapping import OccupancyMap
from uwsim.mapping.other_trees import NODES, PLAIN


def tree_of(kind: bytes, folder: Path) -> tuple[OccupancyMap, Path, bytes]:
    """A map, and its file as a tree of another type, as OctoMap writes it, with what that adds to each node."""
    plain = OccupancyMap(resolution_m=0.1)
    plain.insert_scan(np.random.default_rng(2).uniform(-2, 2, (500, 3)).astype(np.float32), np.zeros(3), np.inf)
    plain.write(folder / "plain.ot")
    header, _, body = (folder / "plain.ot").read_bytes().partition(b"\ndata\n")
    nodes = np.frombuffer(body, PLAIN)
    more = np.zeros(len(nodes), NODES[kind][0])
    for key in PLAIN.names or ():
        more[key] = nodes[key]
    if "colour" in (more.dtype.names or ()):
        more["colour"] = (7, 8, 9)
    content = header.replace(b"id OcTree", b"id " + kind) + b"\ndata\n" + more.tobytes()
    (folder / "other.ot").write_bytes(content)
    return plain, folder / "other.ot", content


@pytest.mark.parametrize("kind", NODES)
def test_its_occupancy_is_that_of_the_plain_tree(kind: bytes, tmp_path: Path) -> None:
    plain, path, content = tree_of(kind, tmp_path)
    with pytest.warns(UserWarning, match=f"is a {kind.decode()}, read as occupancy: its"):
        found = OccupancyMap.read(path)
    assert found.to_bytes("ot") == plain.to_bytes("ot")
    binary = path.with_name("other.bt")  # as its writeBinary writes it
    binary.write_bytes(plain.to_bytes("bt").replace(b"id OcTree", b"id " + kind))
    with pytest.warns(UserWarning, match=f"is a {kind.decode()}, read as occupancy: its"):
        assert OccupancyMap.read(binary).to_bytes("bt") == plain.to_bytes("bt")
    path.write_bytes(content[:-2])
    with pytest.raises(ValueError, match=r"map '.*other\.ot': cut short"):
        OccupancyMap.read(path)
