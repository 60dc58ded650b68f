"""`uwsim map score` on small maps of the pool."""

import json
from pathlib import Path

import pytest
import yaml

from pool_maps import VOXEL_M, error_of, read_figure, uwsim_map, write_pool_maps
from uwsim.mapping import OccupancyMap
from uwsim.mapping.files import write_cloud
from uwsim.scenario.read.assets import assets_folder
from uwsim.scoring.survey_track import SurveyTrack


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_pool_maps(tmp_path_factory.mktemp("maps"))


def test_a_good_map_scores_well_and_a_part_of_it_does_not(folder, tmp_path):
    shown = uwsim_map(
        "score", folder / "pool.bt", "--scenario", "pool", "--out", tmp_path / "s.png", "--json", tmp_path / "s"
    )
    whole = json.loads((tmp_path / "s").read_text())
    assert whole["coverage"] > 0.98
    assert whole["precision"] > 0.99
    assert whole["recall"] > 0.9
    assert whole["distance_p95_m"] < VOXEL_M
    assert whole["s44_order"] == "Exclusive"
    assert whole["s44_share_2"] == 1.0
    assert "precision of occupied voxels" in shown
    read_figure(tmp_path / "s.png")
    uwsim_map("score", folder / "part.bt", "--scenario", "pool", "--out", tmp_path / "p.png", "--json", tmp_path / "p")
    assert json.loads((tmp_path / "p").read_text())["coverage"] < 0.9


@pytest.mark.parametrize(("raised_m", "order"), [(0.5, "2"), (1.0, None)])
def test_a_raised_map_has_that_seabed_error_and_a_lesser_order(folder, tmp_path, raised_m, order):
    options = ("--scenario", "pool", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json")
    uwsim_map("score", folder / "pool.bt", *options)
    placed = json.loads((tmp_path / "s.json").read_text())
    uwsim_map("score", folder / "pool.bt", *options, "--origin", "0", "0", raised_m)
    raised = json.loads((tmp_path / "s.json").read_text())
    assert abs(placed["seabed_error_mean_m"]) <= VOXEL_M / 2 + 0.01
    assert raised["seabed_error_mean_m"] - placed["seabed_error_mean_m"] == pytest.approx(-raised_m)
    assert (placed["s44_order"], raised["s44_order"]) == ("Exclusive", order)
    assert raised["precision"] < 0.1


def test_without_a_track_coverage_is_unknown(folder, tmp_path):
    (tmp_path / "map.bt").write_bytes((folder / "pool.bt").read_bytes())
    shown = uwsim_map("score", tmp_path / "map.bt", "--scenario", "pool", "--json", tmp_path / "s.json")
    assert "no track of the survey" in shown
    alone = json.loads((tmp_path / "s.json").read_text())
    assert alone["coverage"] is None
    assert alone["precision"] > 0.99
    assert (tmp_path / "map.score.png").exists()
    write_cloud(tmp_path / "flown.xyz", SurveyTrack.read(folder / "track.npz").path_world_m)
    uwsim_map(
        "score", tmp_path / "map.bt", "--scenario", "pool", "--track", tmp_path / "flown.xyz", "--json", tmp_path / "j"
    )
    assert json.loads((tmp_path / "j").read_text())["coverage"] > 0.98


def test_a_box_is_scored_by_itself_also_in_a_scenario_without_a_survey(folder, tmp_path):
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    bare = {key: value for key, value in yaml.safe_load(text).items() if key != "survey"}
    (tmp_path / "bare.yaml").write_text(yaml.safe_dump({**bare, "name": "pool"}))
    options = ("--scenario", tmp_path / "bare.yaml", "--json", tmp_path / "s.json", "--out", tmp_path / "s.png")
    west, south = SurveyTrack.read(folder / "track.npz").area_world_m.min(axis=0)
    east, north = SurveyTrack.read(folder / "track.npz").area_world_m.max(axis=0)
    seen = (west, south, 0.7 * west + 0.3 * east, north)  # part.bt ends at a third
    uwsim_map("score", folder / "part.bt", *options, "--area", *seen)
    scored = json.loads((tmp_path / "s.json").read_text())
    assert scored["coverage"] > 0.95
    assert 0 < scored["occupied_voxels"] < len(OccupancyMap.read(folder / "part.bt").occupied_voxels())
    (tmp_path / "map.bt").write_bytes((folder / "part.bt").read_bytes())
    uwsim_map("score", tmp_path / "map.bt", *options)  # without a track either: where the map is
    assert json.loads((tmp_path / "s.json").read_text())["precision"] > 0.99
    assert "west must be less than east" in error_of("score", folder / "part.bt", *options, "--area", 1, 0, -1, 2)


def test_an_empty_map_is_scored_too(folder, tmp_path):
    uwsim_map(
        "score", folder / "empty.bt", "--scenario", "pool", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json"
    )
    empty = json.loads((tmp_path / "s.json").read_text())
    assert (empty["coverage"], empty["precision"], empty["distance_mean_m"]) == (0.0, None, None)


def test_the_packaged_pool_has_a_survey_to_score():
    assert "survey:" in (assets_folder() / "scenarios" / "pool.yaml").read_text()
