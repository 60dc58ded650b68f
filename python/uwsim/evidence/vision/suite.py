"""The range: conditions by seeds, each with all effects and with one kind of them off."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.evidence.vision.colmap import Joined, joined
from uwsim.evidence.vision.judges import Judged, judged
from uwsim.evidence.vision.sequence import Condition, orbit, shots

CONDITIONS = (
    Condition("sun"),
    Condition("overcast", without=("caustics", "shafts", "shadows")),
    Condition("low sun", sun_deg=15.0),
    Condition("coastal", jerlov="1C"),
    Condition("murky", jerlov="5C"),
    Condition("night", sun_deg=-6.0),
)
KINDS = {
    "light": ("caustics", "shafts", "shadows"),
    "motion": ("shutter",),
    "turbidity": ("backscatter", "forward_scatter", "particles", "wobble", "sediment"),
    "sensor": ("noise", "vignetting"),
}
"""Effects that are switched off together. Attenuation stays: without it no water would be left."""
ALL = "all"
MOST_LOST = 0.5
"""The share of pairs solved below which a page prints no drift: lost pairs count with the true motion."""


@dataclass(frozen=True)
class Row:
    """Marks of a condition: means over seeds with all effects, and with each kind of effects off.

    joined: the same by COLMAP, of the first seed's orbit, if one was flown.
    """

    condition: str
    marks: dict[str, Judged]
    joined: dict[str, Joined] = field(default_factory=dict)

    def gained(self, kind: str, mark: str) -> float:
        """Return by how much a mark is better without a kind of effects."""
        change = getattr(self.marks[kind], mark) - getattr(self.marks[ALL], mark)
        return float(-change if mark == "drift" else change)


def flown(
    scenario: str,
    seeds: Sequence[int],
    frames: int,
    conditions: Sequence[Condition] = CONDITIONS,
    report: Callable[[str], None] = print,
    pictures: int = 0,
) -> list[Row]:
    """Return a row for each condition; report: called with a line before each sequence. Raises ValueError.

    pictures: of an orbit for COLMAP, which must be installed; 0: none.
    """
    rows = []
    for number, condition in enumerate(conditions, 1):
        marks: dict[str, Judged] = {}
        models: dict[str, Joined] = {}
        for kind, off in {ALL: (), **KINDS}.items():
            report(
                f"{number}/{len(conditions)} {condition.name}: {'all effects' if kind == ALL else f'without {kind}'}"
            )
            found = [judged(list(shots(scenario, condition, seed, frames, off))) for seed in seeds]
            marks[kind] = Judged(*(float(np.mean([getattr(each, f.name) for each in found])) for f in fields(Judged)))
            if pictures:
                around = orbit(scenario, condition, seeds[0], pictures, off)
                models[kind] = joined({f"{k:03d}.png": frame for k, frame in enumerate(around)})
        rows.append(Row(condition.name, marks, models))
    return rows


def write(folder: Path, rows: Sequence[Row], scenario: str, seeds: Sequence[int], frames: int) -> list[Path]:
    """Write vision.json and vision.md into a folder, and return their paths."""
    about = {"scenario": scenario, "seeds": list(seeds), "frames": frames, "uwsim": version("uwsim")}
    content = {
        **about,
        "rows": [
            {"condition": row.condition}
            | {k: asdict(m) for k, m in row.marks.items()}
            | ({"colmap": {k: asdict(m) for k, m in row.joined.items()}} if row.joined else {})
            for row in rows
        ],
    }
    paths = [folder / "vision.json", folder / "vision.md"]
    write_atomically(paths[0], (json.dumps(content, indent=1) + "\n").encode())
    write_atomically(paths[1], _page(rows, about).encode())
    return paths


def _page(rows: Sequence[Row], about: dict[str, object]) -> str:
    lines = [
        f"# Vision over {about['scenario']}",
        "",
        f"Seeds {about['seeds']}, {about['frames']} stereo pairs each, uwsim {about['uwsim']}. Tracks, stereo and "
        "complete: shares, best 1; drift: share of the way.",
        "",
        "| condition | tracks | stereo | complete | drift |",
        "|---|---|---|---|---|",
        *(
            f"| {row.condition} | {m.tracks:.2f} | {m.stereo:.2f} | {m.complete:.2f} | {_drift(m)} |"
            for row in rows
            for m in [row.marks[ALL]]
        ),
        "",
        "What each kind of effects takes: the mark without it, minus the mark with all.",
        "",
        f"| condition | {' | '.join(f'{mark}: {kind}' for mark in ('tracks', 'drift') for kind in KINDS)} |",
        "|---" * (1 + 2 * len(KINDS)) + "|",
        *(
            f"| {row.condition} | "
            + " | ".join(f"{row.gained(kind, mark):+.2f}" for mark in ("tracks", "drift") for kind in KINDS)
            + " |"
            for row in rows
        ),
        *_models(rows),
    ]
    return "\n".join(lines) + "\n"


def _models(rows: Sequence[Row]) -> list[str]:
    """Return the lines of COLMAP's table, if orbits were flown."""
    if not any(row.joined for row in rows):
        return []
    kinds = (ALL, *KINDS)
    return [
        "",
        "COLMAP over the first seed's orbit: pictures registered, and the path's rms error as a share of the way, with "
        "all effects and without each kind.",
        "",
        f"| condition | {' | '.join(kinds)} |",
        "|---" * (1 + len(kinds)) + "|",
        *(f"| {row.condition} | " + " | ".join(_model(row.joined[kind]) for kind in kinds) + " |" for row in rows),
    ]


def _model(model: Joined) -> str:
    return f"{model.registered:.2f}, " + ("lost" if model.path is None else f"{model.path:.2%}")


def _drift(marks: Judged) -> str:
    return "lost" if marks.complete < MOST_LOST else f"{marks.drift:.2f}"
