"""The cost of a tether of 100 elements: still, in a sea, on the bed and round a pile, beside MoorDyn's.

All cases alternate within one run, so that other load affects them equally. Times are CPU times of the process, on one
thread, for a simulated second. MoorDyn, which is not a dependency (`pip install moordyn`), steps a hanging line of as
many elements with a step near the largest at which it is stable (at 1e-4 s it is not); without it, its case is left
out.
"""

from __future__ import annotations

import statistics
import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from _harness import alternated, console, ratio, spent_s

from uwsim import Simulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

ELEMENTS, LENGTH_M = 100, 50.0
LEAST_REAL_TIMES = 100.0
SEA = {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.0}  # 64 waves
PILE = {"kind": "cylinder", "name": "pile", "position_m": [0, 1, -10], "radius_m": 0.3, "length_m": 24}
MOORDYN_STEP_S = 5e-5


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; medians over them are reported.")] = 7,
    seconds: Annotated[float, typer.Option(min=0.1, help="Simulated seconds of each case in a round.")] = 2.0,
) -> dict[str, Any]:
    """Measure all cases alternately and print real-time factors, and ratios to the vehicle alone and to MoorDyn."""
    cases: dict[str, Any] = {
        "no tether": Run(),
        "still water": Run(tethered=True),
        "in a sea": Run(tethered=True, water={"surface": SEA}),
        "on the bed": Run(tethered=True, mass_kg_m=0.1),
        "round a pile": Run(tethered=True, pile=True),
    }
    try:
        cases["MoorDyn"] = MoorDyn()
    except ImportError:
        console.print("MoorDyn is not installed: its case is left out (pip install moordyn)")
    times = alternated({name: partial(case.second_s, seconds) for name, case in cases.items()}, rounds, warm_up=True)
    results: dict[str, Any] = {}
    for name, spent in times.items():
        factor = 1.0 / statistics.median(spent)
        results[name] = {"real_time_factor": factor, "of_no_tether": ratio(spent, times["no tether"])}
        line = f"{name:14s} {factor:8.1f} times real time, {results[name]['of_no_tether']:7.1f} of a vehicle alone"
        if "MoorDyn" in times and name != "MoorDyn":
            results[name]["faster_than_moordyn"] = ratio(times["MoorDyn"], spent)
            line += f", {results[name]['faster_than_moordyn']:.1f} times as fast as MoorDyn"
        if name not in ("no tether", "MoorDyn"):
            line += f"; {'within' if factor >= LEAST_REAL_TIMES else 'BELOW'} {LEAST_REAL_TIMES:g}"
        console.print(line)
    return results


class Run:
    """A vehicle that flies to and fro on a tether, over a flat bed 20 m deep."""

    def __init__(
        self, *, tethered: bool = False, pile: bool = False, water: dict[str, Any] | None = None, **tether: float
    ) -> None:
        rov: dict[str, Any] = {"name": "rov", "model": "bluerov2_heavy", "start": {"position_m": [15, 0, -8]}}
        if tethered:
            rov["tether"] = {"anchor": [-15, 0, -2], "length_m": LENGTH_M, "elements": ELEMENTS, **tether}
        terrain = {"source": "noise", "size_m": [120, 120], "spacing_m": 1, "bed_depth_m": 20, "hill_height_m": 0}
        values = {"name": "bench", "terrain": terrain, "water": water or {}, "vehicles": [rov]}
        values["obstacles"] = [PILE] if pile else []
        self._sim = Simulator(validated(Scenario, values))
        self._turn = 0

    def second_s(self, seconds: float) -> float:
        """Return the time that a simulated second takes."""
        self._turn += 1
        self._sim.rov.set_effort(surge=0.3 if self._turn % 2 else -0.3, sway=0.2)
        return spent_s(lambda: self._sim.advance(seconds)) / seconds


class MoorDyn:
    """MoorDyn's line of the same elements, hung between fixed ends."""

    def __init__(self) -> None:
        import moordyn  # type: ignore[import-not-found]

        self._moordyn, self._time_s = moordyn, 0.0
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "line.txt"
            file.write_text(LINE)
            self._system = moordyn.Create(str(file))
            moordyn.Init(self._system, [], [])

    def second_s(self, seconds: float) -> float:
        """See Run."""

        def advance() -> None:
            for _ in range(round(seconds / 0.005)):
                self._moordyn.Step(self._system, [], [], self._time_s, 0.005)
                self._time_s += 0.005

        return spent_s(advance) / seconds


LINE = f"""--- MoorDyn input
a Fathom tether
--- LINE TYPES
Name Diam MassDen EA BA EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s) (N-m^2) (-) (-) (-) (-)
t 0.0076 0.043 6.5e4 65 0 1.2 1 0.01 0
--- POINTS
ID Type X Y Z M V CdA Ca
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Fixed -15 0 -2 0 0 0 0
2 Fixed 15 0 -8 0 0 0 0
--- LINES
ID LineType A B Length Segments Outputs
(#) (name) (#) (#) (m) (-) (-)
1 t 1 2 {LENGTH_M} {ELEMENTS} -
--- OPTIONS
0 writeLog
{MOORDYN_STEP_S} dtM
9.80665 g
1000 WtrDnsty
20 WtrDpth
3e5 kBot
3e4 cBot
0 FrictionCoefficient
5.0 TmaxIC
1.0 dtIC
4 CdScaleIC
1e-3 threshIC
--- END
"""
