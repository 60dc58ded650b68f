"""The laws that hold for any input of a reader."""

from __future__ import annotations

import os
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Any, NamedTuple

from tests.fuzz.readers import READERS, REFUSED


class Outcome(NamedTuple):
    """The outcome of one input: its content, None if it was refused, and the warnings and the error (`said`)."""

    content: Any
    said: str


class Laws:
    """Checks a reader's laws. folder: for its files; by default in memory, since a fuzzer writes millions."""

    def __init__(self, name: str) -> None:
        memory = Path("/dev/shm")
        self._reader = READERS[name]
        self.folder = Path(tempfile.mkdtemp(dir=memory if os.access(memory, os.W_OK) else None))

    def hold(self, data: bytes) -> Outcome:
        """Read an input; raise any undocumented error of the reader, and AssertionError for a silent truncation."""
        whole = self._read(data)
        if whole.content is not None and self._reader.has_end(data):
            for cut in {1, 3, len(data) // 2} - {0}:
                part = self._read(data[:-cut])
                assert part.content is None or part.said or part.content == whole.content, (
                    f"without its last {cut} bytes, the input is read as another one, silently"
                )
        return whole

    def close(self) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)

    def _read(self, data: bytes) -> Outcome:
        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("always", UserWarning)
            try:
                content = self._reader.read(data, self.folder)
            except REFUSED as error:
                return Outcome(None, str(error))
        return Outcome(content, " ".join(str(warning.message) for warning in issued))
