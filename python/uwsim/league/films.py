"""Films of a run, one for each goal: ten seconds with the picture, the chart and what was judged."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.campaigns.film import make_film
from uwsim.exercises.exercise import Exercise
from uwsim.figures.reel import Reel

LENGTH_S, BEFORE_S, FPS = 10.0, 7.0, 5.0
PICTURE, CHART, TEXT = (480, 270), 270, 60
"""Pixels of the picture, of the square chart beside it, and of the height of the text below."""
INK, PALE, WATER, MET, MISSED = "#1b2733", "#9fb3c2", "#eef4f8", "#2a8c4a", "#b03030"
Floats = NDArray[np.float64]


def film_goals(
    exercise: Exercise, sheet: Mapping[str, Any], track: Sequence[Sequence[float]], recording: Path, out: Path,
    *, length_s: float = LENGTH_S, size: tuple[int, int] = PICTURE,
) -> list[Path]:  # fmt: skip
    """Film each goal of a run; return the files.

    A goal that was met is filmed from 7 s before; another at the end of the run. exercise: of the run's seed. track:
    rows of time, x, y. recording: the run's. size: of the picture. out: the beginning of the files' names. Raises
    ValueError or OSError.
    """
    met_s = {each["text"]: each["time_s"] for each in sheet["log"] if each["kind"] == "goal"}
    made = []
    for goal, model in zip(sheet["goals"], exercise.in_world().goals, strict=True):
        at_s = met_s.get(goal["title"], sheet["time_s"])
        until_s = min(max(at_s - min(BEFORE_S, length_s), 0.0) + length_s, sheet["time_s"])
        film = out.with_name(f"{out.name}-{goal['name']}.webp")
        require_own(film)
        from_s = max(until_s - length_s, 0.0)
        with TemporaryDirectory() as folder:
            plain = Path(folder, "film.webp")
            make_film(
                recording, plain, size="x".join(map(str, size)), fps=FPS, quality="draft", from_s=from_s,
                until_s=until_s, workers=0,
            )  # fmt: skip
            frames = sorted(plain.with_suffix(".frames").glob("*.png"))
            seen = _Judged(goal, getattr(model, "position_m", None), np.array(track), met_s.get(goal["title"]), size[0])
            reel = Reel(len(frames), partial(seen.frame_of, frames, from_s))
            write_atomically(film, reel.encoded("webp", [round(1000 / FPS)] * len(frames), quality=60, method=4))
        made.append(film)
    return made


class _Judged:
    """Draws what is judged beside a picture.

    place_m: the goal's, if it has one. met_s: when it was met, if it was. left: the picture's width.
    """

    def __init__(
        self,
        goal: Mapping[str, Any],
        place_m: Sequence[float] | None,
        track: Floats,
        met_s: float | None,
        left: int,
    ) -> None:
        self._goal, self._place_m, self._track, self._met_s, self._left = goal, place_m, track, met_s, left
        self._font = ImageFont.load_default(14)
        points = track[:, 1:3] if place_m is None else np.vstack((track[:, 1:3], place_m[:2]))
        self._middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        self._scale = 0.85 * CHART / max(float(np.ptp(points, axis=0).max()), 1.0)

    def frame_of(self, files: Sequence[Path], from_s: float, number: int) -> Image.Image:
        """Return a frame by its number, of the film that begins at a time."""
        return self.frame(Image.open(io.BytesIO(files[number].read_bytes())), from_s + number / FPS)

    def frame(self, picture: Image.Image, time_s: float) -> Image.Image:
        """Return a picture with the chart at its right and the judgement below."""
        found = Image.new("RGB", (self._left + CHART, CHART + TEXT), "white")
        found.paste(picture, (0, 0))
        draw = ImageDraw.Draw(found)
        draw.rectangle((self._left, 0, self._left + CHART, CHART), fill=WATER)
        past = self._track[self._track[:, 0] <= time_s + 1e-6, 1:3]
        is_met = self._met_s is not None and time_s >= self._met_s - 1e-6
        draw.line([self._pixel(p) for p in self._track[:, 1:3]], fill=PALE, width=1)
        if len(past) > 1:
            draw.line([self._pixel(p) for p in past], fill=INK, width=2)
        if self._place_m is not None:
            self._ring(draw, self._place_m, 7, MET if is_met else MISSED)
        if len(past):
            self._ring(draw, past[-1], 3, INK)
        text = "not met in this run" if self._met_s is None else f"met at {self._met_s:.1f} s"
        lines = (
            f"{self._goal['title']}: {self._goal['scored']:.1f} of {self._goal['points']:g} points",
            f"{time_s:.1f} s: {'met' if is_met else 'not met yet'}; {text}; judged: {self._goal['kind']}",
        )
        for k, line in enumerate(lines):
            draw.text(
                (10, CHART + 8 + 24 * k), line, fill=INK if k == 0 else MET if is_met else MISSED, font=self._font
            )
        return found

    def _pixel(self, point_m: Sequence[float] | Floats) -> tuple[float, float]:
        x, y = self._scale * (np.asarray(point_m)[:2] - self._middle)
        return self._left + 0.5 * CHART + float(x), 0.5 * CHART - float(y)

    def _ring(self, draw: ImageDraw.ImageDraw, point_m: Sequence[float] | Floats, radius: int, ink: str) -> None:
        x, y = self._pixel(point_m)
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=ink, width=3)
