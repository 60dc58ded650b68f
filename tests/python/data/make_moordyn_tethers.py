"""Write moordyn_tethers.json: MoorDyn's shapes and tensions, which uwsim.evidence.validate.peers.tethers compares.

MoorDyn (https://github.com/FloatingArrayDesign/MoorDyn) is a lumped-mass model of mooring lines that is developed
independently. Run it in an environment of its own, with `pip install moordyn` (2.7.2 computed the stored results):

    python tests/python/data/make_moordyn_tethers.py
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import moordyn  # type: ignore[import-not-found]
import numpy as np

OUT = Path(__file__).parents[3] / "python/uwsim/evidence/validate/peers/moordyn_tethers.json"
DEPTH_M = 60.0
LINE = {"diameter_m": 0.02, "mass_kg_m": 1.0, "axial_stiffness_n": 2e5, "normal_drag": 1.2, "tangential_drag": 0.01}


def hanging(name: str, end_m: list[float], length_m: float, **line: float) -> dict[str, Any]:
    return {"name": name, "start_m": [0.0, 0.0, -10.0], "end_m": end_m, "length_m": length_m, "line": LINE | line}


STILL = [
    hanging("level", [30.0, 0.0, -10.0], 36.0),
    hanging("level, nearly taut", [30.0, 0.0, -10.0], 30.6),
    hanging("level, slack", [10.0, 0.0, -10.0], 40.0),
    hanging("inclined", [20.0, 0.0, -30.0], 32.0),
    hanging("steep", [4.0, 0.0, -40.0], 34.0),
    hanging("oblique", [18.0, 14.0, -25.0], 32.0),
    hanging("elastic", [30.0, 0.0, -10.0], 33.0, axial_stiffness_n=5e3),
    hanging("very elastic", [20.0, 0.0, -30.0], 29.0, axial_stiffness_n=2e3),
    hanging("light", [30.0, 0.0, -10.0], 36.0, mass_kg_m=0.35),
    hanging("floating", [20.0, 0.0, -30.0], 32.0, mass_kg_m=0.2) | {"settles_s": 120},
    hanging("thick and floating", [25.0, 5.0, -20.0], 30.0, diameter_m=0.05, mass_kg_m=1.5),
    hanging("lies on the bed", [30.0, 0.0, -59.9], 64.0),
    hanging("barely touches the bed", [20.0, 0.0, -59.9], 56.0),
    hanging("hangs to the bed between its ends", [40.0, 0.0, -10.0], 125.0),
]


def falling(name: str, mass_kg: float, drop_m: float, length_m: float, **line: float) -> dict[str, Any]:
    """A mass that starts below the anchor, a metre beside it, and falls until its tether stops it."""
    below = [1.0, 0.0, -5.0 - (length_m - drop_m)]
    case = {"name": name, "start_m": [0.0, 0.0, -5.0], "end_m": below, "length_m": length_m, "line": LINE | line}
    return case | {"mass_kg": mass_kg, "duration_s": 3.0}


SNAPS = [
    falling("snap", 30.0, 0.5, 20.0, axial_stiffness_n=2e4, axial_damping_n_s=200.0),
    falling("snap of a heavy mass", 200.0, 0.5, 20.0, axial_stiffness_n=6.5e4, axial_damping_n_s=500.0),
    falling("snap after a deep fall", 50.0, 2.0, 20.0, axial_stiffness_n=2e4, axial_damping_n_s=200.0),
    falling("snap of a short tether", 30.0, 0.3, 6.0, axial_stiffness_n=2e4, axial_damping_n_s=100.0),
    falling("snap of a soft tether", 30.0, 1.0, 20.0, axial_stiffness_n=4e3, axial_damping_n_s=100.0),
    falling("snap of a light tether", 30.0, 0.5, 20.0, mass_kg_m=0.35, axial_stiffness_n=2e4, axial_damping_n_s=200.0),
]


def text(case: dict[str, Any], segments: int) -> str:
    line = case["line"]
    volume = 0.0
    free = "Free" if "mass_kg" in case else "Fixed"
    rows = " ".join(f"{x:g}" for x in case["end_m"])
    return f"""--- MoorDyn input
{case["name"]}
--- LINE TYPES
Name Diam MassDen EA BA EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s) (N-m^2) (-) (-) (-) (-)
t {line["diameter_m"]} {line["mass_kg_m"]} {line["axial_stiffness_n"]} {line.get("axial_damping_n_s", 100.0)} 0 \
{line["normal_drag"]} 1 {line["tangential_drag"]} 0
--- POINTS
ID Type X Y Z M V CdA Ca
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Fixed {" ".join(f"{x:g}" for x in case["start_m"])} 0 0 0 0
2 {free} {rows} {case.get("mass_kg", 0.0)} {volume} 0 0
--- LINES
ID LineType A B Length Segments Outputs
(#) (name) (#) (#) (m) (-) (-)
1 t 1 2 {case["length_m"]} {segments} -
--- OPTIONS
0 writeLog
{2e-5 if "mass_kg" in case else 2e-4} dtM
9.80665 g
1000 WtrDnsty
{DEPTH_M} WtrDpth
3e5 kBot
3e4 cBot
0 FrictionCoefficient
{0.0 if "mass_kg" in case else 30.0} TmaxIC
1.0 dtIC
4 CdScaleIC
1e-5 threshIC
--- END
"""


def run(case: dict[str, Any]) -> dict[str, Any]:
    segments = 20 if "mass_kg" in case else 60
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "case.txt"
        file.write_text(text(case, segments))
        system = moordyn.Create(str(file))
        moordyn.Init(system, [], [])
        line = moordyn.GetLine(system, 1)
        if "mass_kg" not in case:
            time_s = 0.0
            for _ in range(case.get("settles_s", 20) * 10):
                time_s += 0.1
                moordyn.Step(system, [], [], time_s - 0.1, 0.1)
            points = [moordyn.GetLineNodePos(line, k) for k in range(0, segments + 1, 6)]
            ends = [round(float(np.linalg.norm(moordyn.GetLineNodeTen(line, k))), 5) for k in (0, segments)]
            moordyn.Close(system)
            return case | {"segments": segments, "points_m": np.round(points, 5).tolist(), "end_tensions_n": ends}
        peak, at_s, lowest = 0.0, 0.0, 0.0
        steps = round(case["duration_s"] / 0.001)
        for k in range(steps):
            moordyn.Step(system, [], [], 0.001 * k, 0.001)
            tension = float(np.linalg.norm(moordyn.GetLineNodeTen(line, 0)))
            lowest = min(lowest, float(moordyn.GetLineNodePos(line, segments)[2]))
            if tension > peak:
                peak, at_s = tension, 0.001 * (k + 1)
        moordyn.Close(system)
    peaks = {"peak_tension_n": round(peak, 5), "peak_s": round(at_s, 5), "lowest_m": round(lowest, 5)}
    return case | {"segments": segments} | peaks


if __name__ == "__main__":
    groups = {"still": [run(case) for case in STILL], "snaps": [run(case) for case in SNAPS]}
    rows = [f' "{kind}": [\n' + ",\n".join(f"  {json.dumps(case)}" for case in cases) for kind, cases in groups.items()]
    OUT.write_text("{\n" + "\n ],\n".join(rows) + "\n ]\n}\n")
