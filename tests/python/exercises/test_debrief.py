"""Tests of debriefing films: what is shown of a run, and that its pictures are those times with their judgement."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from uwsim.exercises import Exercise
from uwsim.exercises.debrief import AFTER_S, BEFORE_S, FPS, Decisive, contacts, film_debrief, half_minutes, judged
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.words import Words
from uwsim.missions import wait

RAM = {
    "title": "Ram", "brief": "Dive to the floor.", "scenario": "pool", "time_s": 8.0, "pass_points": 5,
    "start": {"position_m": [0, 0, -2.6]},
    "goals": [{"kind": "reach", "name": "here", "title": "Be here", "position_m": [0, 0, -2.6], "points": 10},
              {"kind": "hold", "name": "rest", "title": "Rest", "depth_m": 1, "for_s": 9, "points": 20}],
    "limits": [{"kind": "collision", "cost": 5}],
}  # fmt: skip


def ram(vehicle):
    vehicle.set_effort(heave=-1.0)
    yield wait(4.0)


def test_every_moment_is_shown_once_and_those_that_count_most_are_kept() -> None:
    moments = [
        Decisive(time_s, "", 1.0, weight) for time_s, weight in ((15, 1), (100, 5), (112, 5), (400, 3), (590, 9))
    ]
    shown = half_minutes(moments, round(600 * FPS), 1e9)
    for each in moments:
        assert sum(round(FPS * each.time_s) in frames for frames in shown) == 1
    assert all(one.stop < other.start for one, other in pairwise(shown))
    assert {len(frames) / FPS for frames in shown} == {25.0, 42.0, BEFORE_S + AFTER_S}
    kept = half_minutes(moments, round(600 * FPS), 75.0)
    assert kept == [shown[1], shown[3]]  # 42 s and 30 s, which count 10 and 9
    assert half_minutes(moments[:1], 1, 1.0) == [range(1)]


def test_a_debrief_shows_what_the_sheet_judged(tmp_path: Path) -> None:
    run, film = tmp_path / "run.mcap", tmp_path / "film.webp"
    course, _ = fly_exercise(Exercise.model_validate(RAM), ram, record=run, record_topic=("odom",))
    sheet = course.sheet()
    moments = judged(sheet, Words("de"))
    assert [each.points for each in moments] == [10.0, -5.0, 0.0] and moments[-1].weight == 20.0
    assert [each.text for each in moments] == ["+10 Be here", "-5 Kollision", sheet["ended_because"]]
    shares: list[float] = []
    (frames,) = film_debrief(run, film, sheet, size=(32, 18), on_share=shares.append)
    assert shares == sorted(shares) and len(shares) == len(frames) and shares[-1] == 1.0
    assert frames == range(round(FPS * sheet["time_s"]))
    with Image.open(film) as opened:
        assert opened.n_frames == len(frames) and opened.size[0] == 32 + 18  # type: ignore[attr-defined]
    (alone,) = film_debrief(run, film, size=(32, 18))
    assert alone.start == 0
    hit = contacts(np.arange(4.0), [0, 0, 1, 1], Words())
    assert [each.time_s for each in hit] == [2.0, 3.0] and hit[0].points < 0


def test_a_film_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"must end in \.webp"):
        film_debrief(tmp_path / "run.mcap", tmp_path / "film.mp4")
    with pytest.raises(ValueError, match=r"lang = 'fr': must be one of de, en"):
        film_debrief(tmp_path / "run.mcap", tmp_path / "film.webp", lang="fr")


def test_a_broken_limit_and_the_end_have_the_words_of_the_page() -> None:
    words = Words("de")
    assert words.limit("depth", "Below 5 m") == "Zu tief (Below 5 m)" and words.limit("mine", "Mine") == "Mine"
    assert words.ended("a limit is broken: Depth") == "eine Grenze ist verletzt: Depth"
    assert words.ended("the time is over") == "die Zeit ist um"
    assert words.ended("broken off: elsewhere") == "broken off: elsewhere"
