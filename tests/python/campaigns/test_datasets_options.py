"""Datasets along tracks, and option values that are refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from command_line import error_line, uwsim
from uwsim import make_dataset
from uwsim.campaigns.datasets.make import Dataset
from uwsim.campaigns.datasets.spec import DatasetSpec
from uwsim.campaigns.datasets.track import read_track
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.validated import validated

SMALL = {"size": (32, 24), "write": ("depth",), "workers": 0}
MISSION = """
from uwsim.missions import wait

def mission(vehicle):
    vehicle.undock()
    vehicle.set_effort(surge=0.3, yaw=0.2)
    yield wait(3.0)
"""


def lines_of(folder: Path) -> list[dict]:
    return [json.loads(line) for line in (folder / "frames.jsonl").read_text().splitlines()]


def test_frames_lie_evenly_along_a_track_and_neighbours_stay_in_one_split(tmp_path: Path) -> None:
    count = 41
    yaw = np.linspace(0.0, 1.0, count)
    places = np.column_stack([np.linspace(-3.0, 0.0, count), np.zeros(count), np.full(count, -2.5)])
    turns = Rotation.from_euler("z", yaw[:, None])
    np.savez(tmp_path / "own.npz", position_world_m=places, orientation_xyzw=turns.as_quat(), time_s=yaw)
    make_dataset("pool", tmp_path / "data", 21, along=tmp_path / "own.npz", **SMALL)
    lines = lines_of(tmp_path / "data")
    bodies = np.array([line["world_from_body"] for line in lines])
    np.testing.assert_allclose(bodies[:, :3, 3], places[::2], atol=1e-12)
    np.testing.assert_allclose(bodies[:, :3, :3], turns[::2].as_matrix(), atol=1e-12)
    assert [line["time_ns"] for line in lines] == [round(1e9 * at) for at in yaw[::2]]
    splits = [line["split"] for line in lines]
    assert splits.count("val") == 4
    with pytest.raises(ValueError, match="n = 42: the track has 41 poses"):
        make_dataset("pool", tmp_path / "more", 42, along=tmp_path / "own.npz", **SMALL)
    with pytest.raises(ValueError, match="look_at: has no effect along a track"):
        make_dataset("pool", tmp_path / "more", 4, along=tmp_path / "own.npz", look_at=("box",), **SMALL)


def test_a_missions_flight_and_its_file_give_the_same_frames(tmp_path: Path) -> None:
    (tmp_path / "turn.py").write_text(MISSION)
    flown = uwsim(
        "run", str(tmp_path / "turn.py"), "--scenario", "pool", "--out", str(tmp_path / "out"), "--report", "none"
    )
    assert flown.returncode == 0, flown.stderr
    make_dataset("pool", tmp_path / "file", 5, along=tmp_path / "out" / "track-rov.csv", **SMALL)
    make_dataset("pool", tmp_path / "flown", 5, mission=tmp_path / "turn.py", **SMALL)
    for one, other in zip(lines_of(tmp_path / "file"), lines_of(tmp_path / "flown"), strict=True):
        np.testing.assert_allclose(
            one["world_from_body"], other["world_from_body"], atol=1e-4
        )  # the file stores six digits
        assert one["time_ns"] == pytest.approx(other["time_ns"], abs=1e4)


def test_a_survey_s_track_heads_along_its_path(tmp_path: Path) -> None:
    path = np.column_stack([np.zeros(20), np.linspace(0.0, 4.0, 20), np.full(20, -3.0)])
    np.savez(tmp_path / "track.npz", path_world_m=path)
    track = read_track(tmp_path / "track.npz")
    assert Rotation.from_quat(track.orientations_xyzw).as_euler("ZYX")[:, 0] == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"PK damaged", "is damaged"),
        ({"position_world_m": np.zeros((3, 3))}, "has no array orientation_xyzw"),
        ({"position_world_m": np.zeros((3, 2)), "orientation_xyzw": np.zeros((3, 4))}, r"must be \(3, 3\)"),
        ({"position_world_m": np.zeros((3, 3)), "orientation_xyzw": np.ones((3, 4))}, "unit quaternions"),
        ({"position_world_m": np.full((1, 3), np.nan), "orientation_xyzw": np.eye(4)[3:]}, "must be finite"),
        ({"path_world_m": np.zeros((1, 3))}, "two positions or more"),
    ],
)
def test_tracks_that_are_none_are_refused(tmp_path: Path, content: bytes | dict, told: str) -> None:
    file = tmp_path / "track.npz"
    file.write_bytes(content) if isinstance(content, bytes) else np.savez(file, **content)
    with pytest.raises(ValueError, match=told):
        read_track(file)
    (tmp_path / "sparse.csv").write_bytes(bytes(200_000))
    with pytest.raises(ValueError, match=r"sparse\.csv: a binary file"):
        read_track(tmp_path / "sparse.csv")


def test_any_camera_can_follow_a_track_but_only_a_fixed_one_is_drawn(tmp_path: Path) -> None:
    np.savez(tmp_path / "t.npz", position_world_m=[[0.0, 0, -2.5]], orientation_xyzw=[[0.0, 0, 0, 1]])
    make_dataset("pool", tmp_path / "chased", 1, along=tmp_path / "t.npz", camera="chase", **SMALL)
    with pytest.raises(ValueError, match=r"camera = 'chase': poses are drawn for .*\(front, down\)"):
        make_dataset("pool", tmp_path / "drawn", 1, camera="chase", **SMALL)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"camera": "aft"}, "camera = 'aft': must be one of"),
        ({"look_at": ("bax",)}, "look_at = 'bax': .*did you mean 'box'"),
        ({"write": ("depht",)}, "write"),
        ({"write": ("depth", "depth")}, "must not contain duplicates"),
        ({"effects": "nois"}, "effects"),
        ({"sonar": "forward_looking"}, "sonar.*has no effect"),
        ({"pictures": "jpg"}, "pictures.*has no effect"),
        ({"label_range_m": 3.0}, "label_range_m = 3 m: has no effect"),
        ({"min_pixels": 3}, "min_pixels = 3.*has no effect"),
        ({"write": ("yolo",)}, "needs rgb"),
        ({"write": ("multibeam",)}, "size: have no effect"),
        ({"vehicle": "scout"}, "scout"),
        ({"vary": {"optics.jerlow": {"choices": ["I"]}}}, "jerlow"),
        ({"vary": {"optics.jerlov": {"choices": ["I", "XX"]}}}, "XX"),
        ({"distance_m": (6.0, 2.0)}, "minimum, then the maximum"),
        ({"distance_m": (500.0, 600.0)}, "no pose was found among .* looks at"),
        ({"n": 0}, "n = 0"),
        ({"depth": 3}, "depth"),
    ],
)
def test_options_are_met_at_the_door(tmp_path: Path, options: dict, told: str) -> None:
    given = {"n": 1, **SMALL, **options}
    with pytest.raises(ValueError, match=told):
        make_dataset("pool", tmp_path / "data", given.pop("n"), **given)
    assert not (tmp_path / "data").exists()


def test_a_scenario_that_changed_meanwhile_is_another(tmp_path: Path) -> None:
    file = tmp_path / "pond.yaml"
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    for width_m in (1.0, 2.0):
        file.write_text(text.replace("size_m: [1, 1, 1]", f"size_m: [1, {width_m}, 1]"))
        out = tmp_path / f"{width_m}"
        make_dataset(file, out, 1, **SMALL)
    digests = [json.loads((tmp_path / f"{w}" / "dataset.json").read_text())["scenario_digest"] for w in (1.0, 2.0)]
    assert digests[0] != digests[1]
    (out / "ledger.jsonl").unlink()
    with pytest.raises(ValueError, match="holds pictures already"):
        make_dataset(file, out, 1, **SMALL)


def test_the_command_makes_a_dataset(tmp_path: Path) -> None:
    out = tmp_path / "data"
    options = ["--n", "3", "--size", "32x24", "--workers", "0", "--look-at", "box", "--distance", "1.2..3",
               "--vary", "optics.sun_elevation_deg=20..60", "--out", str(out)]  # fmt: skip
    made = uwsim("dataset", "pool", *options)
    assert made.returncode == 0, made.stderr
    assert "frames/s" in made.stdout and str(out / "dataset.json") in made.stdout
    assert "holds a dataset already" in error_line(uwsim("dataset", "pool", *options))
    spec = validated(DatasetSpec, {"scenario": "pool", "n": 2000})
    shown = "<Dataset 'data': 1,000 of 2,000 frames of pool, 5.0 frames/s>"
    assert repr(Dataset(spec, Path("data"), 1000, (), 10, 2.0)) == shown


def spec_of(**options: object) -> DatasetSpec:
    return validated(DatasetSpec, {"scenario": "pool", "n": 1, **options})


def test_text_is_read_as_on_the_command_line() -> None:
    assert spec_of(size="640x360").size == (640, 360)
    assert spec_of(distance_m="1..6.5").distance_m == (1.0, 6.5)
    assert spec_of(write="rgb, depth", look_at="box", effects="noise+wobble").write == ("rgb", "depth")
    texts = ("optics.jerlov=II,3C", "optics.wind_m_s=0..5")
    assert spec_of(vary=texts) == spec_of(vary={"optics.jerlov": "II,3C", "optics.wind_m_s": "0..5"})
    for wrong in ({"size": "640"}, {"distance_m": "3"}, {"vary": ("a=1..b",)}, {"vary": ("a",)}):
        with pytest.raises(ValueError, match="must be"):
            spec_of(**wrong)


@pytest.mark.parametrize(
    ("brief", "whole"),
    [
        ("II,III", {"choices": ["II", "III"]}),
        (["II", "III"], {"choices": ["II", "III"]}),
        ("10..80", {"low": 10, "high": 80}),
        ((10, 80), {"low": 10, "high": 80}),
        ("true,false", {"choices": [True, False]}),
        ({"low": 10, "high": 80}, {"low": 10, "high": 80}),
    ],
)
def test_variations_may_be_written_briefly_in_python_as_on_the_command_line(brief: object, whole: object) -> None:
    assert spec_of(vary={"a": brief}).vary == spec_of(vary={"a": whole}).vary


def test_the_pieces_of_cover_can_be_looked_at_by_class_and_by_name(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(
        "name: a\nterrain: {source: noise, size_m: [20, 20], spacing_m: 1, bed_depth_m: 8}\n"
        "cover: [{kind: starfish, name: stars, density_per_m2: 0.1, size_m: [0.5, 0.5]}]\n"
        "vehicles: [{name: rov, model: rov, start: {position_m: [0, 0, -4]}}]\n"
    )
    few = {**SMALL, "size": (96, 72), "write": ("classes", "boxes"), "pitch_max_deg": 60, "min_pixels": 4}
    for look_at in ("starfish", "stars"):
        out = tmp_path / look_at
        make_dataset(tmp_path / "a.yaml", out, 3, look_at=(look_at,), distance_m=(1.5, 2.5), val_share=0.0, **few)
        train = json.loads((out / "annotations/instances_train.json").read_text())
        (star,) = (each["id"] for each in train["categories"] if each["name"] == "starfish")
        seen = {each["image_id"] for each in train["annotations"] if each["category_id"] == star}
        assert seen == {each["id"] for each in train["images"]}
    with pytest.raises(ValueError, match=r"look_at = 'starfsh': .*did you mean 'starfish'"):
        make_dataset(tmp_path / "a.yaml", tmp_path / "no", 1, look_at=("starfsh",), **few)
