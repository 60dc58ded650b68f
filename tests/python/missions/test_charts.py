"""GeoJSON and KML: lines and points are routes, polygons areas, whose lanes have heading, entry, overlap and ties."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim.flight.coverage import lanes_flown
from uwsim.flight.field_flight import FieldNote
from uwsim.flight.fly import fly
from uwsim.flight.flyable_lanes import survey_plan
from uwsim.flight.request import survey_changes, swath_m, with_survey
from uwsim.flight.survey import run_survey
from uwsim.flight.terminal import Silent
from uwsim.mapping.files.georeference import Home
from uwsim.missions import LawnMowerPlan
from uwsim.missions.field import FieldFileError, read_mission_file
from uwsim.scenario import ScenarioError, load

BAY = Home(54.4, 10.2)
SQUARE = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0), (-3.0, -3.0)]


def positions(points: list[tuple[float, float]], *z: float) -> list[list[float]]:
    return [[float(v) for v in BAY.degrees(np.array(point))[::-1]] + list(z) for point in points]


def feature(kind: str, coordinates: Any, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}


def geojson(*features: Any) -> str:
    return json.dumps({"type": "FeatureCollection", "features": features})


def kml(shapes: str) -> str:
    return f'<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document>{shapes}</Document></kml>'


AREA = geojson(feature("Polygon", [positions(SQUARE)], name="bay", heading=30, altitude_m=1.5, fill="#f00"))
PLACEMARK = "<Placemark><name>{}</name>{}</Placemark>"
COORDINATES = " ".join(",".join(map(str, place)) for place in positions(SQUARE))
KML_AREA = kml(
    PLACEMARK.format(
        "bay",
        f"<Polygon><outerBoundaryIs><LinearRing><coordinates>{COORDINATES}</coordinates></LinearRing></outerBoundaryIs>"
        "</Polygon>",
    )
)


@pytest.mark.parametrize(("name", "text"), [("a.geojson", AREA), ("a.kml", KML_AREA)])
def test_a_polygon_is_the_area_of_a_survey(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.warns(FieldNote, match="not on Earth: the middle of .*bay' is assumed at"):
        changes = survey_changes("pool", tmp_path / name, entry="north-east", cross_lines=1)
    np.testing.assert_allclose(changes["area_m"], SQUARE[:4], atol=1e-3)
    survey = with_survey("pool", changes).survey
    assert survey is not None and survey.line_spacing_m == 2.0
    assert (survey.heading_deg, survey.altitude_m) == ((30.0, 1.5) if name == "a.geojson" else (None, 2.0))


def test_lanes_have_their_heading_entry_overlap_and_cross_lines() -> None:
    plan = LawnMowerPlan(SQUARE[:4], 2.0, 2.0, heading_deg=90.0, cross_lines=2, entry="north-east", tilt_deg=90.0)
    lanes = plan.lanes_near(np.array([-50.0, -50.0]))
    assert lanes[0].start_m == pytest.approx([3.0, 2.0]) and len(lanes) == 5
    assert [round(math.degrees(lane.heading_rad)) % 180 for lane in lanes] == [0, 0, 0, 90, 90]
    scenario = with_survey("pool", survey_changes("pool", overlap=25.0))
    assert scenario.survey is not None
    assert scenario.survey.line_spacing_m == pytest.approx(0.75 * swath_m(scenario))
    with_down = with_survey("pool", {"tilt_deg": 90.0, "altitude_m": 2.0})
    sonar = load("pool").vehicles[0].sonar
    assert sonar is not None
    opening_rad = math.radians(sonar.loaded.band().field_of_view_deg)
    assert swath_m(with_down) <= 2 * 2.0 * math.tan(opening_rad / 2) * (1 + 1e-12)


def test_a_survey_of_a_file_is_flown_with_its_lanes(tmp_path: Path) -> None:
    (tmp_path / "a.geojson").write_text(AREA)
    with pytest.warns(FieldNote):
        changes = survey_changes("pool", tmp_path / "a.geojson", cross_lines=1)
    flown = run_survey("pool", tmp_path / "out", survey=changes, report="none", screen=Silent())
    lanes = lanes_flown(flown.events)
    assert lanes is not None and lanes.lanes == 6 and lanes.flown_m > 0.95 * lanes.planned_m
    headings = {round(math.degrees(lane.heading_rad)) % 180 for lane in survey_lanes(changes)}
    assert headings == {60, 150}, "30 deg from north, and across"


def test_a_scenario_without_a_survey_is_surveyed_at_an_assumed_speed_and_what_it_lacks_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.geojson").write_text(AREA)
    (tmp_path / "a.kml").write_text(KML_AREA)
    with pytest.warns(FieldNote, match=r"scenario 'cove': has no survey: 0.5 m/s is assumed"):
        changes = survey_changes("cove", tmp_path / "a.geojson", spacing_m=2.0)
    survey = with_survey("cove", changes).survey
    assert survey is not None and (survey.speed_m_s, survey.altitude_m, survey.line_spacing_m) == (0.5, 1.5, 2.0)
    with pytest.warns(FieldNote) as notes:
        changes = survey_changes("cove", tmp_path / "a.geojson", speed=0.7, altitude_m=4.0, spacing_m=3.0)
    survey = with_survey("cove", changes).survey
    assert survey is not None and (survey.speed_m_s, survey.altitude_m, survey.line_spacing_m) == (0.7, 4.0, 3.0)
    assert not any("m/s is assumed" in str(note.message) for note in notes)
    words = "'cove': has no survey: needs --altitude, or 'altitude' of the area and --spacing, --overlap or"
    with pytest.warns(FieldNote), pytest.raises(ScenarioError, match=words):
        with_survey("cove", survey_changes("cove", tmp_path / "a.kml"))


def survey_lanes(changes: dict[str, Any]) -> Any:
    survey = with_survey("pool", changes).survey
    assert survey is not None
    return survey_plan(survey).lanes_near(np.zeros(2))


def test_lines_and_points_are_routes_with_their_heights(tmp_path: Path) -> None:
    line = feature("LineString", positions(SQUARE[:2], -2.0))
    (tmp_path / "r.geojson").write_text(geojson(line, feature("Point", positions([(0, 0)])[0], name="mark")))
    mission = read_mission_file(tmp_path / "r.geojson")
    assert [(item.frame, item.z) for item in mission.items] == [(0, -2.0)] * 2
    assert mission.notes == ("1 points beside the lines (feature 2 'mark'): left out",)
    points = feature("Point", positions([(0, 0)])[0], depth=3, heading=45), feature("Point", positions([(1, 0)])[0])
    (tmp_path / "r.geojson").write_text(geojson(*points))
    mission = read_mission_file(tmp_path / "r.geojson")
    assert [(i.command, i.param1, i.z) for i in mission.items] == [(16, 0, -3), (115, 45, 0), (16, 0, 0)]
    assert "feature 2: no altitude and no depth: flown at the surface" in mission.notes[0]
    sea = "<LineString><altitudeMode>relativeToSeaFloor</altitudeMode><coordinates>10,54,2 10,54.1,3</coordinates>"
    (tmp_path / "r.kml").write_text(kml(PLACEMARK.format("line", f"{sea}</LineString>") + "<NetworkLink/>"))
    mission = read_mission_file(tmp_path / "r.kml")
    assert [(item.frame, item.z, item.x) for item in mission.items] == [(10, 2, 540000000), (10, 3, 541000000)]
    assert mission.notes == ("1 NetworkLink: left out",)


def test_an_area_is_flown_by_run_as_well(tmp_path: Path) -> None:
    (tmp_path / "a.kml").write_text(KML_AREA)
    with pytest.raises(ValueError, match="placemark 1 'bay': has no altitude: --set altitude_m=3 gives it"):
        fly(tmp_path / "a.kml", "pool")
    settings = {"altitude_m": 2.0, "spacing_m": 3.5, "first_at_m": (0, 0), "speed_m_s": 0.8}
    with pytest.warns(FieldNote):
        lanes = lanes_flown(fly(tmp_path / "a.kml", "pool", arguments=settings).events)
    assert lanes is not None and lanes.lanes == 2 and lanes.flown_m > 0.95 * lanes.planned_m


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (geojson(feature("Polygon", [[[10, 54], [11, 54]]])), "feature 1: has 2 corners: must be in [3, 10000]"),
        (geojson(feature("Polygon", [[[10, 154], [11, 54], [11, 55]]])), "latitude = 154 deg: must be in [-90, 90]"),
        (geojson(feature("Circle", [])), "feature 1: geometry 'Circle': must be one of Point"),
        (geojson(feature("Point", [[1]])), "feature 1, position 1"),
        (geojson(feature("Point", [1, 2], depth="deep")), "feature 1: depth = 'deep': must be a number"),
        ('{"type": "FeatureCollection", "features": 3}', "features = 3: must be a list"),
        ('{"type": "Point", "crs": "EPSG:25832", "coordinates": [1, 2]}', "crs = 'EPSG:25832': must be longitude"),
        ("<kml><Placemark><Point/></Placemark></kml>", "placemark 1: Point: has no coordinates"),
        ("<kml><Point></kml>", "must be XML"),
        ('<!DOCTYPE kml [<!ENTITY a "aaaa">]><kml>&a;</kml>', "has a DOCTYPE: must have none"),
    ],
)
def test_a_chart_that_cannot_be_read_is_refused_with_the_place(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "chart").write_text(text)
    with pytest.raises(FieldFileError) as caught:
        read_mission_file(tmp_path / "chart")
    assert str(caught.value).startswith(str(tmp_path / "chart")) and words in str(caught.value)
