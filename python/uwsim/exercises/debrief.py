"""film_debrief: the decisive half minutes of a recorded run, with the picture, the chart and what was judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.exercises.words import Words
from uwsim.figures.reel import Reel
from uwsim.recording.filming.options import FilmOptions
from uwsim.recording.filming.roll import Roll
from uwsim.recording.filming.shot import shoot
from uwsim.recording.filming.shots import shots_of
from uwsim.recording.glance import glance

BEFORE_S, AFTER_S, LONGEST_S = 20.0, 10.0, 120.0
"""Times shown before and after a moment, and the longest film."""
FPS, PICTURE = 5.0, (480, 270)
TEXT, BAR, SHOWN_S = 62, 14, 4.0
"""Pixels of the height of the text and of the time line, and how long a moment's words and the last picture stay."""
INK, PALE, WATER, GAINED, LOST = "#1b2733", "#9fb3c2", "#eef4f8", "#1f7a3e", "#b03030"
Floats = NDArray[np.float64]


class Decisive(NamedTuple):
    """A moment that decided. points: gained, or lost if below 0. weight: what it counts beside others."""

    time_s: float
    text: str
    points: float = 0.0
    weight: float = 0.0


def film_debrief(
    recording: str | Path, out: str | Path, sheet: Mapping[str, Any] | None = None, *, camera: str = "chase",
    size: tuple[int, int] = PICTURE, longest_s: float = LONGEST_S, threads: int | None = None, lang: str = "en",
    on_share: Callable[[float], object] = lambda share: None,
) -> list[range]:  # fmt: skip
    """Film the decisive half minutes of a run; return the frames that are shown, FPS to the simulated second.

    recording: of the run from time 0, which is repeated bit for bit. out: the film, .webp. sheet: of an exercise: its
    goals, its broken limits and its end are the moments; without one, the contacts and the end are. The moments that
    count least are left out where all would take more than longest_s. camera: as for make_film. lang: of the page's
    languages. on_share: gets the share of the pictures that have been made, 0 to 1. Raises ValueError or OSError.
    """
    recording, out, words = Path(recording), Path(out), Words(lang)
    if out.suffix != ".webp":
        raise ValueError(f"film '{out}': must end in .webp")
    require_own(out)
    if (start := glance(recording).start).tick:
        raise ValueError(f"recording '{recording}': begins at {start.tick * start.step_s:g} s: must begin at 0 s")
    until_s = {} if sheet is None else {"until_s": max(sheet["time_s"], 1.0 / FPS)}
    wanted = FilmOptions(camera=camera, size="x".join(map(str, size)), fps=FPS, quality="draft", **until_s)
    roll = Roll.of(recording, wanted)
    times_s = np.array([1e-9 * state.time_ns for state in roll.states])
    moments = contacts(times_s, roll.collisions, words) if sheet is None else judged(sheet, words)
    shown = half_minutes(moments, len(times_s) - 1, longest_s)
    track = np.array([state.positions_m[roll.vehicle][:2] for state in roll.states])
    frame = Frame(moments, shown, times_s, track, _places(sheet), size, _title(sheet, words))
    total = sum(map(len, shown))
    with TemporaryDirectory() as folder:
        made: list[tuple[int, str]] = []
        for number, frames in enumerate(shown):
            into = Path(folder, str(number))
            into.mkdir()
            shots = shots_of(recording, roll.part(frames), into, wanted, threads)
            for k, shot in zip(frames, shots, strict=True):
                shoot(shot)
                made.append((k, shot.path))
                on_share(len(made) / total)
        reel = Reel(len(made), partial(_framed, frame, made))
        times_ms = [round(1000 / FPS)] * (len(made) - 1) + [round(1000 * SHOWN_S)]
        write_atomically(out, reel.encoded("webp", times_ms, quality=60, method=4))
    return shown


def judged(sheet: Mapping[str, Any], words: Words) -> list[Decisive]:
    """Return the moments of an exercise that gained or lost points, and its end, which counts what was not gained."""
    found = [(each["time_s"], each["text"], each["points"]) for each in sheet["log"] if each["kind"] == "goal"]
    for each in sheet["broken"]:
        found.append((each["time_s"], words.limit(each["kind"], each["title"]), -each["cost"]))
    missed = sheet["points"] - sum(goal["scored"] for goal in sheet["goals"])
    end = Decisive(sheet["time_s"], words.ended(sheet["ended_because"]), weight=missed)
    return [*(Decisive(at_s, f"{points:+g} {text}", points, abs(points)) for at_s, text, points in found), end]


def contacts(times_s: Floats, collisions: Sequence[int], words: Words) -> list[Decisive]:
    """Return the moments of a flight: its contacts, and its end."""
    at = times_s[1:][np.diff(collisions) > 0].tolist()
    return [*(Decisive(time_s, words.contact, -1.0, 1.0) for time_s in at), Decisive(float(times_s[-1]), words.end)]


def half_minutes(moments: Sequence[Decisive], frames: int, longest_s: float = LONGEST_S) -> list[range]:
    """Return the frames around the moments, in order and without overlap.

    Moments whose half minutes overlap are shown together. Of more than fit, those that count most are kept.
    """
    groups: list[tuple[range, float]] = []
    for each in sorted(moments):
        start, stop = (round(FPS * (each.time_s + shift)) for shift in (-BEFORE_S, AFTER_S))
        start, stop = min(max(start, 0), frames - 1), min(max(stop, 1), frames)
        if groups and start <= groups[-1][0].stop:
            (before, weight) = groups.pop()
            groups.append((range(before.start, max(stop, before.stop)), weight + each.weight))
        else:
            groups.append((range(start, stop), each.weight))
    kept: list[range] = []
    for shown, _ in sorted(groups, key=lambda group: -group[1]):
        if not kept or sum(map(len, kept)) + len(shown) <= FPS * longest_s:
            kept.append(shown)
    return sorted(kept, key=lambda shown: shown.start)


class Frame:
    """Draws what was judged around a picture: the chart at its right, words and the run's time line below.

    shown: the frames of the film. times_s: (n,), of all frames. track: (n, 2), in the world [m]. places: the
    goals'.
    """

    def __init__(
        self, moments: Sequence[Decisive], shown: Sequence[range], times_s: Floats, track: Floats,
        places: Sequence[Sequence[float]], size: tuple[int, int], title: str,
    ) -> None:  # fmt: skip
        self._moments, self._shown, self._times_s, self._track = moments, shown, times_s, track
        self._places, self._size, self._title = places, size, title
        self._font = ImageFont.load_default(15)
        seen = np.vstack([track, *(np.array([place[:2]]) for place in places)])
        self._middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
        self._scale = 0.85 * size[1] / max(float(np.ptp(seen, axis=0).max()), 1.0)

    def drawn(self, picture: Image.Image, k: int) -> Image.Image:
        """Return a frame of the film. k: its number in the run."""
        width, height = self._size
        found = Image.new("RGB", (width + height, height + TEXT + BAR), "white")
        found.paste(picture, (0, 0))
        draw = ImageDraw.Draw(found)
        self._chart(draw, k)
        time_s = float(self._times_s[k])
        since = [k - min(round(FPS * each.time_s), len(self._times_s) - 2) for each in self._moments]
        said = [each for each, frames in zip(self._moments, since, strict=True) if 0 <= frames < FPS * SHOWN_S]
        draw.text((10, height + 8), f"{_clock(time_s)}  {self._title}", fill=INK, font=self._font)
        for each in said[-1:]:
            draw.text((10, height + 34), each.text, fill=_ink(each), font=self._font)
        self._time_line(draw, k)
        return found

    def _chart(self, draw: ImageDraw.ImageDraw, k: int) -> None:
        left, edge = self._size
        draw.rectangle((left, 0, left + edge, edge), fill=WATER)
        draw.line([self._pixel(point) for point in self._track], fill=PALE, width=1)
        for place in self._places:
            self._ring(draw, place, 7, PALE)
        if k:
            draw.line([self._pixel(point) for point in self._track[: k + 1]], fill=INK, width=2)
        for each in self._moments:
            at = int(np.searchsorted(self._times_s, each.time_s - 1e-6).clip(max=len(self._track) - 1))
            if each.points and at <= k:
                self._ring(draw, self._track[at], 7, _ink(each))
        self._ring(draw, self._track[k], 3, INK)

    def _time_line(self, draw: ImageDraw.ImageDraw, k: int) -> None:
        top, right = self._size[1] + TEXT, sum(self._size)
        scale = right / max(len(self._times_s) - 1, 1)
        draw.rectangle((0, top, right, top + BAR), fill=WATER)
        for frames in self._shown:
            draw.rectangle((scale * frames.start, top, scale * frames.stop, top + BAR), fill=PALE)
        for each in self._moments:
            x = scale * min(FPS * each.time_s, len(self._times_s) - 1)
            draw.line((x, top, x, top + BAR), fill=_ink(each), width=3)
        draw.rectangle((scale * k - 1, top - 4, scale * k + 1, top + BAR), fill=INK)

    def _pixel(self, point_m: Sequence[float] | Floats) -> tuple[float, float]:
        x, y = self._scale * (np.asarray(point_m)[:2] - self._middle)
        return self._size[0] + 0.5 * self._size[1] + float(x), 0.5 * self._size[1] - float(y)

    def _ring(self, draw: ImageDraw.ImageDraw, point_m: Sequence[float] | Floats, radius: int, ink: str) -> None:
        x, y = self._pixel(point_m)
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=ink, width=3)


def _framed(frame: Frame, made: Sequence[tuple[int, str]], number: int) -> Image.Image:
    k, path = made[number]
    with Image.open(path) as picture:
        return frame.drawn(picture.convert("RGB"), k)


def _places(sheet: Mapping[str, Any] | None) -> list[Sequence[float]]:
    """Return the places of a sheet's goals; sheets of up to 0.3 have none."""
    return [] if sheet is None else [place for goal in sheet["goals"] for place in goal.get("places_m", ())]


def _title(sheet: Mapping[str, Any] | None, words: Words) -> str:
    return "" if sheet is None else f"{sheet['title']}: {words.score(sheet['score'], sheet['points'])}"


def _ink(each: Decisive) -> str:
    return GAINED if each.points > 0 else LOST if each.points < 0 else INK


def _clock(time_s: float) -> str:
    tenths = round(10.0 * time_s)  # so that 59.97 s is not 0:60.0
    return f"{tenths // 600}:{tenths % 600 / 10.0:04.1f}"
