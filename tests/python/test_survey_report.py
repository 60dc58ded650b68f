"""The report is self-contained, shows every key figure, and is valid however early the survey ended."""

import base64
import dataclasses
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from uwsim import _core
from uwsim.figures import truth_and_map
from uwsim.scoring.map_score import score_map
from uwsim.scoring.score_text import order_rows
from uwsim.survey.completeness import coverage_shortfall
from uwsim.survey.record import PingSample, SurveyRecord
from uwsim.survey.report import write_report
from uwsim.survey.report_figures import draw_report_figures
from uwsim.survey.summary import key_figures, summary_table, warning_rows

AREA = np.array([[-8.0, -6.0], [8.0, -6.0], [8.0, 6.0], [-8.0, 6.0]])
NO_VOXELS = np.empty((0, 3))


@pytest.fixture(autouse=True)
def small_panels(monkeypatch):
    monkeypatch.setattr(truth_and_map, "PANEL_PIXELS", 160)


@pytest.fixture
def world():
    x, y = np.meshgrid(np.arange(-20.0, 21.0), np.arange(-20.0, 21.0))
    world = _core.World()
    world.set_terrain((np.sin(x / 4.0) + np.cos(y / 5.0) - 20.0).astype(np.float32), 1.0, (-20.0, -20.0))
    world.add_solid("post", np.array([[0.0, 0, -22], [1, 0, -22], [0, 1, -22], [0.3, 0.3, -14]]), np.array([[0, 1, 3]]))
    return world


@pytest.fixture
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
    return SurveyRecord(
        scenario_name='<b>lake & "co"</b>',
        seed=31415,
        sonar_model="2",
        step_s=0.005,
        voxel_m=0.5,
        threads=2,
        stopped_because="the <proximity> sensor read less than 7 m",
        simulated_s=1312.4,
        wall_s=62.1,
        ping_count=40,
        echo_count=2345,
        collision_count=0,
        path_world_m=path,
        area_world_m=AREA,
        range_max_m=15.0,
        ping_interval_s=0.1,
        ping_interval_requested_s=0.1,
        pings_with_warning={"range": 25, "proximity": 40, "collision": 0},
        warning_limits_m={"range": 110.0, "proximity": 10.0},
        sample_ping=PingSample(ranges, angles, world_from_sonar, points),
        stage_wall_s={"physics": 8.0, "map": 32.0},
    )


def survey(world, record, folder, voxels=None):
    if voxels is None:
        voxels = score_map(world, NO_VOXELS, 0.5, record.path_world_m, AREA, 15.0).visible_centres_m
    score = score_map(world, voxels, 0.5, record.path_world_m, AREA, 15.0)
    figures = draw_report_figures(folder, world, record, score, voxels)
    write_report(folder / "report.html", record, score, 98765, figures)
    return score, figures, (folder / "report.html").read_text(encoding="utf-8")


def texts(page: str) -> str:
    return " ".join(" ".join(ElementTree.fromstring(page).itertext()).split())


def test_the_report_is_well_formed_and_shows_every_key_figure_and_picture(world, record, tmp_path):
    score, figures, page = survey(world, record, tmp_path)
    shown = texts(page)
    for name, value in key_figures(record, score, 98765):
        assert f"{name} {value}" in shown
    for value in (record.scenario_name, str(record.seed), record.stopped_because, "uwsim map render map.bt"):
        assert value in shown
    assert "physics 8.0 s 13 %" in shown
    assert "map (in parallel) 32.0 s" in shown, "with two threads the map has one of its own"
    assert "the rest 54.1 s" in shown

    assert len(figures) == 5
    assert "The seabed by IHO S-44" in shown
    for name, allowed, cells in order_rows(score):
        assert f"{name} {allowed} {cells}" in shown
    embedded = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert [base64.b64decode(text) for text in embedded] == [figure.path.read_bytes() for figure in figures]


def test_table_and_report_show_for_what_share_of_the_pings_each_warning_was_lit(world, record):
    shown = dict(warning_rows(record))
    assert shown == {
        "pings over 110 m from the station": "62.5 %",
        "pings under 10 m above the bed": "100 %",
        "pings in contact": "0 %",
    }
    score = score_map(world, NO_VOXELS, 0.5, record.path_world_m, AREA, 15.0)
    assert set(warning_rows(record)) <= set(key_figures(record, score, 0))
    rare = dataclasses.replace(record, ping_count=100_000, pings_with_warning={"range": 1, "proximity": 99_999})
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
def test_a_survey_that_ended_early_or_has_a_minimum_must_cover_enough(record, coverage, ended_early, least, short):
    flown = dataclasses.replace(record, coverage=coverage, ended_early=ended_early)
    shortfall = coverage_shortfall(flown, least)
    assert (shortfall is not None) == short
    if shortfall and coverage:
        assert "coverage is 48.0 %, must be at least" in shortfall


def test_the_report_needs_no_network_and_escapes_names(world, record, tmp_path):
    page = survey(world, record, tmp_path)[2]
    without_pictures = re.sub(r"base64,[^\"]+", "", page)
    assert not re.search(r"https?:|//|<script|<link|@import|url\(", without_pictures)
    assert "<b>lake" not in page
    assert "&lt;proximity&gt;" in page


def test_the_report_of_a_survey_without_pings_says_so(world, record, tmp_path):
    empty = dataclasses.replace(
        record, ping_count=0, echo_count=0, path_world_m=NO_VOXELS, sample_ping=None, wall_s=0.0, stage_wall_s={},
        simulated_s=0.0, stopped_because="interrupted",
    )  # fmt: skip
    _, figures, page = survey(world, empty, tmp_path, NO_VOXELS)
    names = ["truth_and_map.png", "map_from_above.png", "where_it_is_wrong.png"]
    assert [figure.path.name for figure in figures] == names
    shown = texts(page)
    assert "ended before its first ping" in shown
    assert "The map is empty" in shown
    assert "nan" not in shown
    assert empty.real_time_factor == 0.0


def test_one_ping_and_one_voxel_are_enough_for_a_report(world, record, tmp_path):
    short = dataclasses.replace(record, ping_count=1, path_world_m=record.path_world_m[:1])
    _, figures, page = survey(world, short, tmp_path, np.array([[0.25, 0.25, -19.75]]))
    assert len(figures) == 4
    assert "first ping" not in texts(page)


def test_the_same_survey_gives_the_same_bytes(world, record, tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        folder.mkdir()
        survey(world, record, folder)
    for path in first.iterdir():
        assert path.read_bytes() == (second / path.name).read_bytes()


def test_the_table_shows_the_same_key_figures(world, record, tmp_path):
    score = survey(world, record, tmp_path)[0]
    console = Console(width=100, record=True, file=(tmp_path / "terminal").open("w"))
    console.print(summary_table(dataclasses.replace(record, scenario_name="[red]lake[/red]"), score, 98765))
    shown = console.export_text()
    assert "[red]lake[/red]" in shown
    for name, value in key_figures(record, score, 98765):
        assert re.search(f"{re.escape(name)} .* {re.escape(value)} ", shown)


@pytest.mark.parametrize("columns", [40, 60])
def test_a_narrow_terminal_folds_the_names_and_keeps_the_values(world, record, tmp_path, columns):
    score = survey(world, record, tmp_path)[0]
    console = Console(width=columns, record=True, file=(tmp_path / "terminal").open("w"))
    console.print(summary_table(record, score, 98765))
    shown = console.export_text()
    assert max(len(line) for line in shown.splitlines()) <= columns
    for _, value in key_figures(record, score, 98765):
        assert value in shown


@pytest.mark.parametrize(
    ("record_change", "score_change", "warning"),
    [
        ({}, {}, None),
        ({}, {"coverage": 0.95}, None),
        ({}, {"coverage": 0.9499}, "coverage is 94.9 % of"),
        ({"collision_count": 1}, {}, "The vehicle collided once."),
        ({"collision_count": 1200}, {}, "The vehicle collided 1,200 times."),
        ({"ping_interval_s": 0.15}, {}, "The sonar pinged at 6.67 Hz, not 10: sound takes longer to 15 m and back."),
        ({"ended_early": True}, {}, "The mission ended early (the <proximity> sensor read less than 7 m)"),
    ],
)
def test_table_and_report_show_the_same_warnings(world, record, tmp_path, record_change, score_change, warning):
    score = dataclasses.replace(survey(world, record, tmp_path)[0], **score_change)
    record = dataclasses.replace(record, **record_change)
    write_report(tmp_path / "report.html", record, score, 98765, [])
    console = Console(width=200, record=True, file=(tmp_path / "terminal").open("w"))
    console.print(summary_table(record, score, 98765))
    page, table = (tmp_path / "report.html").read_text(encoding="utf-8"), " ".join(console.export_text().split())
    if warning is None:
        assert 'class="warning"' not in page
        assert "warning" not in table
    else:
        assert warning in texts(page)
        assert f"warning: {warning}" in table or f"warning: The map is incomplete: {warning}" in table


def test_coverage_is_not_rounded_up_to_100_percent(world, record):
    voxels = score_map(world, NO_VOXELS, 0.5, record.path_world_m, AREA, 15.0).visible_centres_m
    score = score_map(world, voxels, 0.5, record.path_world_m, AREA, 15.0)
    almost = dataclasses.replace(score, coverage=0.99996)
    assert dict(key_figures(record, almost, 0))["coverage"].startswith("99.9 %")


@pytest.mark.parametrize("size_m", [1e-4, 1e-9])
def test_a_tiny_area_has_figures_too(world, record, tmp_path, size_m):
    speck = dataclasses.replace(
        record, area_world_m=np.array([[3.0, 2.0]]) + size_m * np.array([[0, 0], [1, 0], [0, 1]])
    )
    score = score_map(world, NO_VOXELS, 0.5, speck.path_world_m, speck.area_world_m, 15.0)
    for tiny in (speck, dataclasses.replace(speck, path_world_m=NO_VOXELS)):
        for figure in draw_report_figures(tmp_path, world, tiny, score, np.array([[3.25, 2.25, -19.75]])):
            width, height = Image.open(figure.path).size
            assert 100 < width < 4000
            assert 100 < height < 4000
