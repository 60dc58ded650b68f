"""ffmpeg: the program that encodes video."""

from __future__ import annotations

import shutil
from importlib.util import find_spec

from uwsim.base.extras import MissingExtraError


def encoder_path(needed_for: str = "--video") -> str:
    """Return the path of ffmpeg: the system's, or that of imageio-ffmpeg. Raises MissingExtraError.

    ffmpeg runs as a separate program because the licence (GPL) of its encoder, x264, rules out linking.
    """
    found = shutil.which("ffmpeg")
    if found is None:
        if find_spec("imageio_ffmpeg") is None:
            raise MissingExtraError(f"{needed_for} needs ffmpeg: apt install ffmpeg, or pip install imageio-ffmpeg")
        from imageio_ffmpeg import get_ffmpeg_exe

        found = get_ffmpeg_exe()
    return str(found)
