"""Reading of texts in an HDF5 file: the script of a contained process; to start quickly, it imports no uwsim."""

from __future__ import annotations

import h5py


def read(path: str, dataset: str, attributes: list[str]) -> dict[str, str]:
    """Read the attributes of a dataset with these names, or itself if there are none, and forget them.

    Texts of any length are stored in a heap of their own, and the library reads a damaged one for ever. An error that
    it raises is no failure here: uwsim's own process gets the same one.
    """
    try:
        with h5py.File(path, "r") as file:
            node = file[dataset]
            for name in attributes:
                node.attrs[name]
            if not attributes:
                node[()]
    except MemoryError:
        raise
    except Exception:  # the reader in uwsim's own process reports it
        pass
    return {}
