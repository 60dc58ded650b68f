"""`uwsim map score` on small maps of the pool."""

import json

import pytest
import yaml

from pool_maps import VOXEL_M, error_of, read_figure, uwsim_map
from uwsim.mapping import OccupancyMap
from uwsim.mapping.files import write_cloud
from uwsim.scenario.read.assets import assets_folder
from uwsim.scoring.survey_track import SurveyTrack


def scored(source, folder, *options, scenario="pool"):
    """Return the scores of a map, whose figure and JSON go into a folder."""
    files = ("--json", folder / "s.json", "--out", folder / "s.png")
    uwsim_map("score", source, "--scenario", scenario, *files, *options)
    return json.loads((folder / "s.json").read_text())


def test_a_good_map_scores_well(folder, tmp_path):
    whole = scored(folder / "pool.bt", tmp_path)
    assert whole["coverage"] > 0.98
    assert whole["precision"] > 0.99
    assert whole["recall"] > 0.9
    assert whole["distance_p95_m"] < VOXEL_M
    assert whole["s44_share_2"] == 1.0
    read_figure(tmp_path / "s.png")


@pytest.mark.usefixtures("blank_figures")
def test_a_part_scores_less_and_a_raised_map_has_that_seabed_error_and_a_lesser_order(folder, tmp_path):
    assert scored(folder / "part.bt", tmp_path)["coverage"] < 0.9
    placed = scored(folder / "pool.bt", tmp_path)
    assert abs(placed["seabed_error_mean_m"]) <= VOXEL_M / 2 + 0.01
    assert placed["s44_order"] == "Exclusive"
    for raised_m, order in ((0.5, "2"), (1.0, None)):
        raised = scored(folder / "pool.bt", tmp_path, "--origin", "0", "0", raised_m)
        assert raised["seabed_error_mean_m"] - placed["seabed_error_mean_m"] == pytest.approx(-raised_m)
        assert raised["s44_order"] == order and raised["precision"] < 0.1
    empty = scored(folder / "empty.bt", tmp_path)
    assert (empty["coverage"], empty["precision"], empty["distance_mean_m"]) == (0.0, None, None)


@pytest.mark.usefixtures("blank_figures")
def test_without_a_track_coverage_is_unknown(folder, tmp_path):
    (tmp_path / "map.bt").write_bytes((folder / "pool.bt").read_bytes())
    shown = uwsim_map("score", tmp_path / "map.bt", "--scenario", "pool", "--json", tmp_path / "s.json")
    assert "no track of the survey" in shown and "precision of occupied voxels" in shown
    alone = json.loads((tmp_path / "s.json").read_text())
    assert alone["coverage"] is None and alone["precision"] > 0.99
    assert (tmp_path / "map.score.png").exists()
    write_cloud(tmp_path / "flown.xyz", SurveyTrack.read(folder / "track.npz").path_world_m)
    assert scored(tmp_path / "map.bt", tmp_path, "--track", tmp_path / "flown.xyz")["coverage"] > 0.98


@pytest.mark.usefixtures("blank_figures")
def test_a_box_is_scored_by_itself_also_in_a_scenario_without_a_survey(folder, tmp_path):
    pool = yaml.safe_load((assets_folder() / "scenarios" / "pool.yaml").read_text())
    bare, area = tmp_path / "bare.yaml", SurveyTrack.read(folder / "track.npz").area_world_m
    bare.write_text(yaml.safe_dump({**pool, "survey": None, "name": "pool"}))
    (west, south), (east, north) = area.min(axis=0), area.max(axis=0)
    box = (west, south, 0.7 * west + 0.3 * east, north)  # part.bt ends at a third
    found = scored(folder / "part.bt", tmp_path, "--area", *box, scenario=bare)
    assert found["coverage"] > 0.95
    assert 0 < found["occupied_voxels"] < len(OccupancyMap.read(folder / "part.bt").occupied_voxels())
    (tmp_path / "map.bt").write_bytes((folder / "part.bt").read_bytes())
    assert scored(tmp_path / "map.bt", tmp_path, scenario=bare)["precision"] > 0.99  # no track either: where the map is
    wrong = error_of("score", folder / "part.bt", "--scenario", bare, "--area", 1, 0, -1, 2)
    assert "west must be less than east" in wrong
