"""ffmpeg: the program that encodes video."""

from __future__ import annotations

import shutil

from uwsim.base.extras import need_extra


def encoder_path(needed_for: str = "--video") -> str:
    """Return the path of ffmpeg: the system's, or the one from the extra `video`. Raises MissingExtraError.

    ffmpeg runs as a separate program because the licence (GPL) of its encoder, x264, rules out linking.
    """
    found = shutil.which("ffmpeg")
    if found is None:
        need_extra("imageio_ffmpeg", "video", needed_for)
        from imageio_ffmpeg import get_ffmpeg_exe

        found = get_ffmpeg_exe()
    return str(found)
