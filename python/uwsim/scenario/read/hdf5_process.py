"""Reading of texts in an HDF5 file, in a process: python hdf5_process.py FILE DATASET ATTRIBUTES BYTES CPU_S.

ATTRIBUTES: names, one a line; if there are none, the dataset itself is read. Texts of any length are stored in a heap
of their own, and the library reads a damaged one for ever. An error that it raises is no failure here: uwsim's own
process gets the same one. To start quickly, this must not import uwsim.
"""

from __future__ import annotations

import os
import resource
import sys

import h5py


def main() -> None:
    """Read all texts within the limits; if they take more memory, print one line to stderr and exit with code 1."""
    path, dataset, attributes = sys.argv[1:4]
    memory_bytes, cpu_s = map(int, sys.argv[4:])
    os.dup2(2, 1)  # keeps the library's output out of the result
    for kind, limit in ((resource.RLIMIT_AS, memory_bytes), (resource.RLIMIT_CPU, cpu_s), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(kind, (limit, limit))

    try:
        with h5py.File(path, "r") as file:
            node = file[dataset]
            for name in attributes.splitlines():
                node.attrs[name]
            if not attributes:
                node[()]
    except MemoryError:
        sys.exit(f"takes more than {memory_bytes / 1e9:.1f} GB to read")
    except Exception:  # the reader in uwsim's own process reports it
        pass


if __name__ == "__main__":
    main()
