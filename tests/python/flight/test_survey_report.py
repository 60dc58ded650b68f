"""The report is self-contained, shows every key value, and is valid however early the survey ended."""

import base64
import dataclasses
import io
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from uwsim import _core
from uwsim.figures import truth_and_map
from uwsim.flight.log import PingSample
from uwsim.flight.record import FlightRecord
from uwsim.flight.report import map_figures, write_page
from uwsim.flight.samples import COLUMNS, Samples
from uwsim.flight.summary import coverage_shortfall, key_figures, summary_table, warning_rows
from uwsim.mapping import OccupancyMap
from uwsim.scoring.map_score import score_map
from uwsim.scoring.score_text import order_rows

AREA = np.array([[-8.0, -6.0], [8.0, -6.0], [8.0, 6.0], [-8.0, 6.0]])
NO_VOXELS = np.empty((0, 3))


@pytest.fixture(scope="module")
def world():
    x, y = np.meshgrid(np.arange(-20.0, 21.0), np.arange(-20.0, 21.0))
    world = _core.World()
    world.set_terrain((np.sin(x / 4.0) + np.cos(y / 5.0) - 20.0).astype(np.float32), 1.0, (-20.0, -20.0))
    world.add_solid("post", np.array([[0.0, 0, -22], [1, 0, -22], [0, 1, -22], [0.3, 0.3, -14]]), np.array([[0, 1, 3]]))
    return world


@pytest.fixture(scope="module")
def record(world):
    path = np.stack([np.linspace(-6.0, 6.0, 40), np.zeros(40), np.full(40, -12.0)], axis=1)
    angles = np.linspace(-1.0, 1.0, 65)
    tilt = 0.9
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    world_from_sonar = np.eye(4)
    world_from_sonar[:3, :3], world_from_sonar[:3, 3] = turn, path[20]
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(65)], axis=1) @ turn.T
    ranges = _core.RayScene(world).cast(path[20:21], directions, 15.0).ranges_m
    echo = np.isfinite(ranges)
    assert 0 < echo.sum() < 65  # some beams have no echo
    points = path[20] + directions[echo] * ranges[echo, None]
    return FlightRecord(
        mission="survey",
        scenario='<b>lake & "co"</b>',
        seed=31415,
        estimate="truth",
        sonar_model="2",
        step_s=0.005,
        voxel_m=0.5,
        threads=2,
        ended_because="the <proximity> sensor read less than 7 m",
        ended_early=False,
        planned=True,
        simulated_s=1312.4,
        wall_s=62.1,
        echo_count=2345,
        free_voxels=98765,
        occupancy=Occupied(),
        pings_world_m={"rov": path},
        area_world_m=AREA,
        range_max_m=15.0,
        ping_interval_s=0.1,
        ping_interval_requested_s=0.1,
        pings_with_warning={"range": 25, "proximity": 40, "collision": 0},
        warning_limits_m={"range": 110.0, "proximity": 10.0},
        sample_ping=PingSample(ranges, angles, world_from_sonar, points),
        stage_wall_s={"physics": 8.0, "map": 32.0},
    )


class Occupied(OccupancyMap):
    """A map with the given occupied voxels."""

    def __init__(self, voxels=NO_VOXELS):
        super().__init__(0.5)
        self._voxels = voxels

    def occupied_voxels(self):
        return self._voxels


def scored(world, record, voxels):
    """Return the record with the score of a map of the given voxels."""
    score = score_map(world, voxels, 0.5, record.path_world_m, record.area_world_m, 15.0)
    return dataclasses.replace(record, occupancy=Occupied(voxels), score=score)


def survey(world, flown, folder):
    """Write the report of a scored record; return it, its figures and the page."""
    figures = map_figures(folder, flown, world, _core.RayScene(world))
    write_page(folder / "report.html", flown, figures)
    return flown, figures, (folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def surveyed(world, record, tmp_path_factory):
    """Return the scored record, its figures, the page and the folder."""
    folder = tmp_path_factory.mktemp("surveyed")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(truth_and_map, "PANEL_PIXELS", 160)
        visible = score_map(world, NO_VOXELS, 0.5, record.path_world_m, AREA, 15.0).visible_centres_m
        return *survey(world, scored(world, record, visible), folder), folder


def without_pings(record, count=0, **changes):
    path = record.path_world_m[:count]
    return dataclasses.replace(record, pings_world_m={"rov": path}, **changes)


def collided(times):
    """Return samples of a flight with this number of collisions."""
    row = np.zeros(len(COLUMNS) + 1)
    row[COLUMNS.index("collisions")] = times
    return {"rov": Samples((*COLUMNS, "effort surge"), row[None])}


def with_score(flown, **changes):
    return dataclasses.replace(flown, score=dataclasses.replace(flown.score, **changes))


def printed(flown, columns):
    """Return the table of a flight as a terminal shows it."""
    console = Console(width=columns, record=True, file=io.StringIO())
    console.print(summary_table(flown))
    return console.export_text()


def texts(page: str) -> str:
    return " ".join(" ".join(ElementTree.fromstring(page).itertext()).split())


def test_the_report_is_well_formed_and_shows_every_key_value_and_picture(record, surveyed):
    flown, figures, page, _ = surveyed
    shown = texts(page)
    for name, value in key_figures(flown):
        assert f"{name} {value}" in shown
    for value in (record.scenario, str(record.seed), record.ended_because, "uwsim map render map.bt"):
        assert value in shown
    assert "physics 8.0 s 13 %" in shown
    assert "map (in parallel) 32.0 s" in shown, "with two threads the map has one of its own"
    assert "the rest 54.1 s" in shown

    assert len(figures) == 5
    assert "The seabed by IHO S-44" in shown
    for name, allowed, cells in order_rows(flown.score):
        assert f"{name} {allowed} {cells}" in shown
    embedded = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert [base64.b64decode(text) for text in embedded] == [figure.path.read_bytes() for figure in figures]


def test_table_and_report_show_for_what_share_of_the_pings_each_warning_was_lit(record, surveyed):
    shown = dict(warning_rows(record))
    assert shown == {
        "pings over 110 m from the station": "62.5 %",
        "pings under 10 m above the bed": "100 %",
        "pings in contact": "0 %",
    }
    assert set(warning_rows(record)) <= set(key_figures(surveyed[0]))
    many = {"rov": np.zeros((100_000, 3))}
    rare = dataclasses.replace(record, pings_world_m=many, pings_with_warning={"range": 1, "proximity": 99_999})
    assert [value for _, value in warning_rows(rare)] == ["0.1 %", "99.9 %"], "neither none nor all"


@pytest.mark.parametrize(
    ("coverage", "ended_early", "least", "short"),
    [
        (0.48, True, None, True),
        (0.96, True, None, False),
        (0.48, False, None, False),
        (0.48, False, 50.0, True),
        (0.48, True, 40.0, False),
        (0.48, True, 0.0, False),
        (None, True, None, True),
    ],
)
def test_a_survey_that_ended_early_or_has_a_minimum_must_cover_enough(surveyed, coverage, ended_early, least, short):
    flown = with_score(surveyed[0], coverage=coverage) if coverage else dataclasses.replace(surveyed[0], score=None)
    shortfall = coverage_shortfall(dataclasses.replace(flown, ended_early=ended_early), least)
    assert (shortfall is not None) == short
    if shortfall and coverage:
        assert "coverage is 48.0 %, must be at least" in shortfall


def test_the_report_needs_no_network_and_escapes_names(surveyed):
    page = surveyed[2]
    without_pictures = re.sub(r"base64,[^\"]+", "", page)
    assert not re.search(r"https?:|//|<script|<link|@import|url\(", without_pictures)
    assert "<b>lake" not in page
    assert "&lt;proximity&gt;" in page


def test_the_report_of_a_survey_without_pings_says_so(world, record, tmp_path):
    empty = without_pings(
        record, echo_count=0, sample_ping=None, wall_s=0.0, stage_wall_s={}, simulated_s=0.0,
        ended_because="interrupted",
    )  # fmt: skip
    _, figures, page = survey(world, scored(world, empty, NO_VOXELS), tmp_path)
    names = ["truth_and_map.png", "map_from_above.png", "where_it_is_wrong.png"]
    assert [figure.path.name for figure in figures] == names
    shown = texts(page)
    assert "ended before its first ping" in shown
    assert "The map is empty" in shown
    assert "nan" not in shown
    assert empty.real_time_factor == 0.0


def test_one_ping_and_one_voxel_are_enough_for_a_report(world, record, tmp_path):
    short = without_pings(record, 1)
    _, figures, page = survey(world, scored(world, short, np.array([[0.25, 0.25, -19.75]])), tmp_path)
    assert len(figures) == 4
    assert "first ping" not in texts(page)


def test_the_same_survey_gives_the_same_bytes(world, surveyed, tmp_path):
    flown, *_, first = surveyed
    survey(world, flown, tmp_path)
    assert {path.name for path in first.iterdir()} == {path.name for path in tmp_path.iterdir()}
    for path in first.iterdir():
        assert path.read_bytes() == (tmp_path / path.name).read_bytes()


def test_the_table_shows_the_same_key_values(surveyed):
    shown = printed(dataclasses.replace(surveyed[0], scenario="[red]lake[/red]"), 100)
    assert "[red]lake[/red]" in shown
    for name, value in key_figures(surveyed[0]):
        assert re.search(f"{re.escape(name)} .* {re.escape(value)} ", shown)


@pytest.mark.parametrize("columns", [40, 60])
def test_a_narrow_terminal_folds_the_names_and_keeps_the_values(surveyed, columns):
    shown = printed(surveyed[0], columns)
    assert max(len(line) for line in shown.splitlines()) <= columns
    assert all(value in shown for _, value in key_figures(surveyed[0]))


@pytest.mark.parametrize(
    ("record_change", "score_change", "warning"),
    [
        ({}, {}, None),
        ({}, {"coverage": 0.95}, None),
        ({}, {"coverage": 0.9499}, "coverage is 94.9 % of"),
        ({"samples": collided(1)}, {}, "There was a collision."),
        ({"samples": collided(1200)}, {}, "There were 1,200 collisions."),
        ({"ping_interval_s": 0.15}, {}, "The sonar pinged at 6.67 Hz, not 10: sound takes longer to 15 m and back."),
        ({"ended_early": True}, {}, "The mission ended early: the <proximity> sensor read less than 7 m."),
    ],
)
def test_table_and_report_show_the_same_warnings(surveyed, tmp_path, record_change, score_change, warning):
    flown = dataclasses.replace(with_score(surveyed[0], **score_change), **record_change)
    write_page(tmp_path / "report.html", flown, [])
    page, table = (tmp_path / "report.html").read_text(encoding="utf-8"), " ".join(printed(flown, 200).split())
    if warning is None:
        assert 'class="warning"' not in page
        assert "warning" not in table
    else:
        assert warning in texts(page)
        assert f"warning: {warning}" in table or f"warning: The map is incomplete: {warning}" in table


def test_coverage_is_not_rounded_up_to_100_percent(surveyed):
    assert dict(key_figures(with_score(surveyed[0], coverage=0.99996)))["coverage"].startswith("99.9 %")


def test_a_tiny_area_has_figures_too(world, record, tmp_path):
    speck = dataclasses.replace(record, area_world_m=np.array([[3.0, 2.0], [3.0 + 1e-9, 2.0], [3.0, 2.0 + 1e-9]]))
    for tiny in (speck, without_pings(speck)):
        flown = scored(world, tiny, np.array([[3.25, 2.25, -19.75]]))
        for figure in map_figures(tmp_path, flown, world, _core.RayScene(world)):
            assert all(100 < size < 4000 for size in Image.open(figure.path).size)
