"""No text from a file is parsed as mathematics, whatever figure shows it: a `$` is a character like any other."""

import ast
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib import mathtext
from matplotlib.text import Text

import uwsim
from uwsim.base.plain_figure import PlainFigure
from uwsim.campaigns.sweeps.figures import draw_distributions, draw_effects, draw_sensitivity
from uwsim.campaigns.sweeps.rows import Rows
from uwsim.campaigns.sweeps.sensitivity import Sensitivity
from uwsim.figures.comparison import draw_comparison, draw_divergence
from uwsim.figures.exercise import draw_errors, draw_exercise_track
from uwsim.figures.flight import draw_power, draw_track
from uwsim.figures.map_plans import draw_map_difference
from uwsim.figures.map_render import Viewpoint, draw_map
from uwsim.figures.rays import draw_rays
from uwsim.figures.scene import draw_scene
from uwsim.figures.style import label_axes, new_figure, save_figure
from uwsim.figures.vehicle import draw_circles, draw_eigenvalues, draw_vehicle
from uwsim.instruments.acoustics.rays_between import rays_between
from uwsim.mapping import OccupancyMap
from uwsim.mapping.changes import map_difference
from uwsim.scenario import load
from uwsim.scenario.spec.vehicle import load_vehicle
from uwsim.scoring import track_plot

PYTHON = Path(uwsim.__file__).parent
WRONG, RIGHT = r"5 $\frac{ and 6 $", "$x$ and $y$"
"""The first is no mathematics; the second is, and would be shown without its `$`."""
TIMES_S = np.linspace(0.0, 10.0, 20)
TRACK_M = np.stack([TIMES_S, 0.1 * TIMES_S, -1.0 - 0.1 * TIMES_S], axis=1)
CURVE = (TIMES_S, np.abs(TRACK_M[:, 2]))


@pytest.fixture
def parsed(monkeypatch):
    """Return the texts that matplotlib parses during a test."""
    found: list[str] = []
    parse = mathtext.MathTextParser.parse

    def noted(self, text, *args, **options):
        found.append(text)
        return parse(self, text, *args, **options)

    monkeypatch.setattr(mathtext.MathTextParser, "parse", noted)
    return found


def rows(text: str) -> Rows:
    table = [
        {"run": k, "seed": k, "error": "", text: k + 1.0, "kind": f"{text}{k % 2}", "y": 0.1 * k} for k in range(8)
    ]
    return Rows(table, [text, "kind"], ["y"])


def effects(path: Path, text: str) -> None:
    vary = {text: SimpleNamespace(scale="log"), "kind": SimpleNamespace(scale="linear")}
    draw_effects(path, SimpleNamespace(vary=vary), rows(text), text, [text, "kind"])


def rays(path: Path, text: str) -> None:
    found = rays_between(load("lake"), (0.0, 0.0, -2.0), (30.0, 0.0, -3.0))
    draw_rays(found.__class__(**{**vars(found), "scenario": text}), path)


def scene(path: Path, text: str) -> None:
    scenario = load("pool").model_copy(update={"name": text})
    draw_scene(path, scenario, uwsim.Simulator("pool").world)


def one_voxel() -> OccupancyMap:
    made = OccupancyMap(resolution_m=0.5)
    made.insert_scan([[0.0, 0.0, -3.0]], (0.0, 0.0, 0.0))
    return made


def maps(path: Path, text: str) -> None:
    draw_map_difference(path, map_difference(one_voxel(), one_voxel()), (text, text))


def vehicle(path: Path, text: str) -> None:
    model = load_vehicle("rov").model_copy(update={"name": text})
    draw_vehicle(path, model, (0.0, 0.0, 0.0), (0.0, 0.0, 0.1), {text: []})


def power(path: Path, text: str) -> None:
    draw_power(path, TIMES_S, np.zeros((20, 2)), [text, "other"], np.full(20, 50.0))


def exercise_track(path: Path, text: str) -> None:
    draw_exercise_track(path, uwsim.Simulator("pool").world, TRACK_M, {text: [(1.0, 1.0, -1.0)]}, [])


FIGURES: dict[str, Callable[[Path, str], object]] = {
    "an exercise's errors": lambda path, text: draw_errors(path, {text: CURVE}),
    "an exercise's track": exercise_track,
    "a flight's track": lambda path, text: draw_track(path, None, {text: TRACK_M}, {text: TRACK_M}),
    "commands": power,
    "a track in a notebook": lambda path, text: path.write_bytes(track_plot.png(track_plot.plot(TRACK_M, title=text))),
    "missions compared": lambda path, text: draw_comparison(path, {text: [CURVE]}),
    "recordings compared": lambda path, text: draw_divergence(path, {text: [(1.0, 1e-3), (2.0, 10.0)]}, text),
    "maps compared": maps,
    "a map": lambda path, text: draw_map(path, one_voxel(), Viewpoint(width=400), text),
    "rays": rays,
    "rays as SVG": lambda path, text: rays(path.with_suffix(".svg"), text),
    "a scenario": scene,
    "a vehicle": vehicle,
    "circles": lambda path, text: draw_circles(path, {text: TRACK_M[:, :2]}),
    "eigenvalues": lambda path, text: draw_eigenvalues(path, {text: np.array([-1.0 + 1.0j])}),
    "a sweep's distributions": lambda path, text: draw_distributions(path, rows(text), [text]),
    "a sweep's effects": effects,
    "a sweep's sensitivity": lambda path, text: draw_sensitivity(
        path, Sensitivity([text], [text], ["rank"], np.array([[0.5]]))
    ),
}


@pytest.mark.parametrize("name", FIGURES)
def test_a_text_from_a_file_is_not_mathematics_and_is_shown(tmp_path, monkeypatch, parsed, name):
    """Matplotlib would also leave labels that begin with an underscore out of legends."""
    shown: list[str] = []
    draw = Text.draw
    monkeypatch.setattr(Text, "draw", lambda self, renderer: (shown.append(self.get_text()), draw(self, renderer))[1])
    for which, text in {"plain": f"plain {WRONG}", "hidden": f"_hidden {RIGHT}"}.items():
        folder = tmp_path / which
        folder.mkdir()
        FIGURES[name](folder / "figure.png", text)
        assert [path.stat().st_size > 0 for path in folder.iterdir()] == [True]
    assert not [each for each in parsed if r"\mathdefault" not in each], "only matplotlib's own numbers"
    assert sum("plain" in each for each in shown) == sum("hidden" in each for each in shown)


def test_numbers_on_a_logarithmic_axis_keep_their_exponents(tmp_path, parsed):
    figure = new_figure(4.0, 3.0)
    axes = figure.add_subplot()
    axes.semilogy([1, 2], [1, 1000])
    label_axes(axes, RIGHT, "", "")
    save_figure(figure, tmp_path / "figure.png")
    assert any("10^{3}" in each for each in parsed)
    assert not axes.title.get_parse_math()


def test_the_users_settings_of_matplotlib_neither_count_nor_change(tmp_path, parsed):
    with matplotlib.rc_context({"text.parse_math": True, "text.usetex": True}):
        figure = track_plot.plot(TRACK_M, title=RIGHT)
        assert matplotlib.rcParams["text.parse_math"] and matplotlib.rcParams["text.usetex"]
        figure.draw_without_rendering()
    titles = [text for text in figure.findobj(Text) if text.get_text() == RIGHT]
    assert titles and not any(text.get_usetex() or text.get_parse_math() for text in titles)


def test_every_figure_of_the_program_is_plain_or_saved_by_save_figure():
    """A new figure made with matplotlib's own class would read texts as mathematics again."""
    makers = {}
    texts = {path: path.read_text() for path in PYTHON.rglob("*.py")}
    for path, text in texts.items():
        if "igure" not in text and "matplotlib.pyplot" not in text:
            continue
        calls = [node.func for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
        names = {call.attr if isinstance(call, ast.Attribute) else getattr(call, "id", "") for call in calls}
        if "import matplotlib.pyplot" in text:
            assert "save_figure" in names and "savefig" not in names, path
            makers[path.name] = "pyplot"
        elif "from matplotlib.figure import Figure" in text and path.name != "plain_figure.py":
            assert "Figure" not in names, path
        elif names & {"PlainFigure", "new_figure"}:
            makers[path.name] = "plain"
    assert len(makers) > 10
    assert isinstance(new_figure(1.0, 1.0), PlainFigure)
