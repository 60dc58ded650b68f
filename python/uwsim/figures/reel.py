"""Many pictures as one image of Pillow, of which one is in memory at a time while an animation is encoded."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Sequence
from typing import Any

from PIL import Image


class Reel(Image.Image):
    """Pictures by number, each read when the encoder gets to it."""

    def __init__(self, count: int, picture: Callable[[int], Image.Image]) -> None:
        super().__init__()
        self.n_frames = count
        self._picture = picture
        self.seek(0)

    def seek(self, frame: int) -> None:
        """Become a picture. Raises EOFError after the last, as Pillow expects."""
        if frame >= self.n_frames:
            raise EOFError(f"picture {frame}: there are {self.n_frames}")
        picture: Any = self._picture(frame)
        picture.load()
        self.im, self._mode, self._size = picture.im, picture.mode, picture.size

    def encoded(self, kind: str, durations_ms: Sequence[int], **options: Any) -> bytes:
        """Return an endless animation, "webp" or "gif", that shows each picture for a time."""
        stream = io.BytesIO()
        self.save(stream, kind, save_all=True, duration=list(durations_ms), loop=0, **options)
        return stream.getvalue()


class PictureStore:
    """Pictures, compressed in a file without a name, which is gone when the process ends, in whatever way."""

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile(prefix="uwsim-film-")  # noqa: SIM115  # closed with the store
        self._ends = [0]

    def __len__(self) -> int:
        return len(self._ends) - 1

    def add(self, picture: Image.Image) -> None:
        """Add a picture. Raises OSError."""
        picture.save(self._file, "png", compress_level=1)
        self._ends.append(self._file.tell())

    def reel(self) -> Reel:
        """Return the pictures as one image."""
        return Reel(len(self), self._read)

    def _read(self, number: int) -> Image.Image:
        start, end = self._ends[number : number + 2]
        self._file.seek(start)
        return Image.open(io.BytesIO(self._file.read(end - start)))
