"""Datasets: the depth, normals, masks and poses of labelled frames agree with each other and with the world."""

import itertools
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from pycocotools.coco import COCO
from ruamel.yaml import YAML

import uwsim
from elsewhere import Elsewhere
from uwsim.base import own_files
from uwsim.campaigns.datasets import studio
from uwsim.campaigns.datasets.files import bounds, run_lengths
from uwsim.campaigns.datasets.spec import DatasetSpec
from uwsim.campaigns.datasets.studio import Studio
from uwsim.campaigns.datasets.tables import split_of_frames
from uwsim.campaigns.workers import campaign
from uwsim.scenario.build.hull import hull_radius_m
from uwsim.scenario.read.assets import assets_folder

BED_M, CENTRE_M, RADIUS_M = -8.0, np.array([0.0, 0.0, -5.0]), 1.0
AQUARIUM = """
name: aquarium
terrain: {source: noise, size_m: [40, 40], spacing_m: 1, bed_depth_m: 8}
station: {position_m: [-12, 0, 0]}
obstacles:
  - {kind: sphere, name: ball, position_m: [0, 0, -5], radius_m: 1}
  - {kind: pipeline, name: pipe, points_m: [[-5, 5], [5, 5]], radius_m: 0.3}
vehicles: [{name: rov, model: small_sonar.yaml, sonar: {model: 2}}]
"""
SONAR = "forward_looking: {kind: forward_looking, "
FRAMES = 6
EVERYTHING = ("rgb", "depth", "normals", "instances", "classes", "boxes", "yolo", "arrays", "sonar", "multibeam")
OPTIONS = {
    "size": (96, 72),
    "without": ("wobble", "distortion"),
    "write": EVERYTHING,
    "look_at": ("ball",),
    "distance_m": (2.0, 5.0),
    "val_share": 0.3,
    "min_pixels": 4,
}


@pytest.fixture(scope="module")
def aquarium(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("world") / "aquarium.yaml"
    path.write_text(AQUARIUM)
    rov = (assets_folder() / "vehicles" / "rov.yaml").read_text()
    assert SONAR in rov
    small = "range_max_m: 12, range_bins: 150, beams: 64, rays_per_column: 96, beam_width_deg: 2, "
    path.with_name("small_sonar.yaml").write_text(rov.replace(SONAR, SONAR + small))
    return path


@pytest.fixture(scope="module")
def data(aquarium: Path, tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A dataset, its tables and its frames' images."""
    out = tmp_path_factory.mktemp("data")
    made = uwsim.make_dataset(aquarium, out, FRAMES, workers=0, **OPTIONS)
    lines = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
    pictures = [
        {kind: np.asarray(Image.open(out / file)) for kind, file in line["files"].items() if file.endswith("png")}
        for line in lines
    ]
    about = json.loads((out / "dataset.json").read_text())
    return SimpleNamespace(out=out, made=made, lines=lines, pictures=pictures, about=about, k=about["camera"]["k"])


def files_of(folder: Path) -> dict[str, bytes]:
    """Return all files except the ledger, whose order is that in which frames were finished."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != "ledger.jsonl"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def points_m(k: np.ndarray, depth_m: np.ndarray) -> np.ndarray:
    """Return the pixels' points (H, W, 3) in the optical frame of a pinhole camera."""
    (fx, _, cx), (_, fy, cy), _ = np.asarray(k)
    v, u = np.indices(depth_m.shape)
    return np.stack([(u - cx) / fx * depth_m, (v - cy) / fy * depth_m, depth_m], axis=-1)


def test_depth_and_pose_give_points_on_the_surfaces_that_the_masks_name_and_normals_are_theirs(
    data: SimpleNamespace,
) -> None:
    ball, terrain = (data.about["label_names"].index(name) for name in ("ball", "terrain"))
    seen = 0
    for line, pictures in zip(data.lines, data.pictures, strict=True):
        pose, hit = np.array(line["world_from_optical"]), pictures["depth"] > 0
        points = points_m(data.k, pictures["depth"] / 1000.0) @ pose[:3, :3].T + pose[:3, 3]
        normals_world = (pictures["normals"] / 127.5 - 1.0) @ pose[:3, :3].T
        of_ball = hit & (pictures["instances"] == ball)
        seen += of_ball.sum()
        from_centre = points[of_ball] - CENTRE_M
        # depth is stored in whole millimetres
        assert np.abs(np.linalg.norm(from_centre, axis=1) - RADIUS_M).max() < 2e-3
        assert np.abs(normals_world[of_ball] - from_centre / RADIUS_M).max(initial=0.0) < 0.01
        of_bed = hit & (pictures["instances"] == terrain)
        assert np.abs(points[of_bed][:, 2] - BED_M).max(initial=0.0) < 2e-3
        assert np.abs(normals_world[of_bed] - (0.0, 0.0, 1.0)).max(initial=0.0) < 0.01
        assert not hit[pictures["normals"].sum(axis=-1) == 0].any()
    assert seen > 200


def test_pycocotools_reads_the_masks_and_boxes_once_for_each_label(data: SimpleNamespace) -> None:
    class_of = {"ball": "structure", "pipe": "pipeline"}
    found: dict[str, dict[int, set[int]]] = {"instances": {}, "sonar": {}}
    for split, (kind, folder) in itertools.product(("train", "val"), (("instances", "images"), ("sonar", "sonar"))):
        coco = COCO(str(data.out / f"annotations/{kind}_{split}.json"))
        for image in coco.loadImgs(coco.getImgIds()):
            labels = data.pictures[image["id"]]["instances" if kind == "instances" else "sonar_instances"]
            assert labels.shape == (image["height"], image["width"])
            assert (data.out / folder / image["file_name"]).is_file()
            things = coco.loadAnns(coco.getAnnIds(imgIds=image["id"]))
            found[kind][image["id"]] = {thing["instance"] for thing in things}
            assert len(found[kind][image["id"]]) == len(things)
            for thing in things:
                mask = labels == thing["instance"]
                assert np.array_equal(coco.annToMask(thing).astype(bool), mask)
                rows, columns = np.nonzero(mask)
                left, top, width, height = thing["bbox"]
                assert (left, top) == (columns.min(), rows.min())
                assert (left + width - 1, top + height - 1) == (columns.max(), rows.max())
                assert thing["area"] == mask.sum()
                assert coco.cats[thing["category_id"]]["name"] == class_of[thing["name"]]
    for line, pictures in zip(data.lines, data.pictures, strict=True):
        labels, counts = np.unique(pictures["instances"], return_counts=True)
        assert found["instances"][line["frame"]] == set(labels[counts >= OPTIONS["min_pixels"]].tolist()) - {0, 1}
        of_label = np.array(data.about["class_of_label"])
        assert np.array_equal(pictures["classes"], of_label[pictures["instances"]])
    assert sum(map(len, found["instances"].values())) >= FRAMES


def test_yolo_s_boxes_are_coco_s(data: SimpleNamespace) -> None:
    width, height = OPTIONS["size"]
    names = YAML(typ="safe").load((data.out / "data.yaml").read_text())["names"]
    for split in ("train", "val"):
        coco = json.loads((data.out / f"annotations/instances_{split}.json").read_text())
        files = [data.out / line for line in (data.out / f"{split}.txt").read_text().splitlines()]
        assert [file.name for file in files] == [image["file_name"] for image in coco["images"]]
        category = {each["id"]: each["name"] for each in coco["categories"]}
        for image, file in zip(coco["images"], files, strict=True):
            rows = Path(str(file).replace("/images/", "/labels/")).with_suffix(".txt").read_text().splitlines()
            things = [thing for thing in coco["annotations"] if thing["image_id"] == image["id"]]
            for row, thing in zip(rows, things, strict=True):
                number, *shares = row.split()
                x, y, across, down = np.array(shares, float) * (width, height, width, height)
                assert names[int(number)] == category[thing["category_id"]]
                assert [x - across / 2, y - down / 2, across, down] == pytest.approx(thing["bbox"], abs=1e-3)


def test_the_sonar_shows_the_ball_where_it_is(data: SimpleNamespace) -> None:
    ball, seen = data.about["label_names"].index("ball"), 0
    sonar = data.about["sonar"]
    for line, pictures in zip(data.lines, data.pictures, strict=True):
        at = np.linalg.inv(np.array(line["world_from_sonar"])) @ np.append(CENTRE_M, 1.0)
        range_m, bearing = np.linalg.norm(at[:3]) - RADIUS_M, np.arctan2(at[1], at[0])
        if abs(at[2]) > 0.3 or abs(bearing) > 0.4 * sonar["field_of_view_rad"]:
            continue
        rows, columns = pictures["sonar_instances"].shape
        row = rows - 1 - int(range_m / sonar["range_max_m"] * rows)
        column = round((columns - 1) * (0.5 - bearing / sonar["field_of_view_rad"]))
        nearby = pictures["sonar_instances"][row - 4 : row + 1, column - 2 : column + 3]
        assert (nearby == ball).any()
        seen += 1
    labels = [pictures["sonar_instances"] for pictures in data.pictures]
    assert seen or any((label == ball).any() for label in labels)


def test_arrays_hold_what_the_pictures_round(data: SimpleNamespace) -> None:
    for line, pictures in zip(data.lines, data.pictures, strict=True):
        arrays = np.load(data.out / line["files"]["arrays"])
        near = arrays["depth_m"] < 65.0
        assert np.abs(1e-3 * pictures["depth"] - arrays["depth_m"])[near].max() <= 0.000501
        levels = np.load(data.out / line["files"]["sonar_arrays"])
        low, high = line["sonar_limits_db"]
        shown = 255.0 * np.clip((levels["level_db"][::-1, ::-1] - low) / (high - low), 0.0, 1.0)
        assert np.abs(shown - pictures["sonar"]).max() <= 0.5001
        ping = np.load(data.out / line["files"]["multibeam"])
        assert ping["ranges_m"].shape == ping["labels"].shape == ping["angles_rad"].shape


def test_drawn_poses_differ_are_in_free_water_and_look_at_something(data: SimpleNamespace, aquarium: Path) -> None:
    sim = uwsim.Simulator(aquarium)
    clear_m = hull_radius_m(sim.scenario.vehicles[0].model) + 0.2
    for line, pictures in zip(data.lines, data.pictures, strict=True):
        body = np.array(line["world_from_body"])
        assert sim.scene.distance_m(body[None, :3, 3])[0] >= clear_m
        assert BED_M + clear_m <= body[2, 3] <= -clear_m
        assert abs(np.degrees(np.arcsin(body[2, 0]))) <= 15.0
        assert line["target"] == "ball"
        assert 2.0 <= line["distance_m"] <= 5.0
        assert (pictures["instances"] == data.about["label_names"].index("ball")).any()
    assert len({line["time_ns"] for line in data.lines}) == FRAMES
    assert len({tuple(np.ravel(line["world_from_body"])) for line in data.lines}) == FRAMES


def test_the_same_bytes_after_a_stop_and_by_other_workers(
    data: SimpleNamespace, aquarium: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped, asked = tmp_path / "stopped", iter([False, False, True])
    begun = uwsim.make_dataset(aquarium, stopped, FRAMES, workers=0, stop_requested=lambda: next(asked), **OPTIONS)
    assert begun.interrupted and begun.finished == 2 and not begun.files
    (stopped / "depth" / ".000003.png.half").write_bytes(b"half")  # a leftover of a killed process
    (stopped / "images" / "000003.png").write_bytes(b"half")
    own_files.mark(stopped / "depth" / ".000003.png.half", unfinished=True)
    own_files.mark(stopped / "images" / "000003.png")
    with pytest.raises(ValueError, match="holds a dataset already, 2 frames"):
        uwsim.make_dataset(aquarium, stopped, FRAMES, workers=0, **OPTIONS)
    with pytest.raises(ValueError, match=r"--resume: .*options"):
        uwsim.make_dataset(aquarium, stopped, FRAMES, workers=0, resume=True, **{**OPTIONS, "seed": 9})
    monkeypatch.setattr(campaign, "open_workers", lambda count, scheduler: Elsewhere(studio._kept.cache_clear))
    done = uwsim.make_dataset(aquarium, stopped, FRAMES, resume=True, **OPTIONS)
    assert done.made == FRAMES - 2 and not done.interrupted
    assert files_of(stopped) == files_of(data.out)


def test_what_is_far_has_no_label(aquarium: Path, tmp_path: Path) -> None:
    options = {**OPTIONS, "write": ("instances", "arrays", "boxes"), "label_range_m": 0.5}
    uwsim.make_dataset(aquarium, tmp_path, 1, workers=0, **options)
    assert not np.asarray(Image.open(tmp_path / "instances/000000.png")).any()
    assert np.load(tmp_path / "arrays/000000.npz")["labels"].any()
    for split in ("train", "val"):
        assert not json.loads((tmp_path / f"annotations/instances_{split}.json").read_text())["annotations"]


def test_parameters_are_drawn_for_each_frame(aquarium: Path, tmp_path: Path) -> None:
    vary = {"optics.jerlov": {"choices": ["I", "5C"]}, "optics.sun_elevation_deg": {"low": 10.0, "high": 80.0}}
    options = {"size": (32, 24), "write": ("rgb", "boxes"), "vary": vary, "pictures": "jpg"}
    uwsim.make_dataset(aquarium, tmp_path, 8, workers=0, **options)
    lines = [json.loads(line) for line in (tmp_path / "frames.jsonl").read_text().splitlines()]
    assert {line["values"]["optics.jerlov"] for line in lines} == {"I", "5C"}
    ranges = {line["values"]["optics.jerlov"]: line["label_range_m"] for line in lines}
    assert ranges["I"] > 50.0 > 5.0 > ranges["5C"]  # 4.8 / c
    assert len({line["values"]["optics.sun_elevation_deg"] for line in lines}) == 8
    with Image.open(tmp_path / "images/000000.jpg") as picture:
        assert picture.size == (32, 24)


def things_in(spec: dict, aquarium: Path, frames: int) -> list[int]:
    """Return the number of objects in each frame of a dataset."""
    studio = Studio(DatasetSpec(scenario=str(aquarium), n=frames, size=(48, 36), write=("boxes",), **spec))
    found = []
    for number in range(frames):
        studio.place(studio.viewpoint(number))
        found.append(len(studio.annotations(studio.picture(studio.time_ns(number)), 1)))
    return found


def test_empty_frames_show_nothing_and_crowded_ones_at_least_what_they_would_otherwise(aquarium: Path) -> None:
    common = {"distance_m": (2.0, 8.0), "min_pixels": 1}
    assert things_in({**common, "empty_share": 1.0}, aquarium, 6) == [0] * 6
    plain, crowded = (things_in({**common, "crowded_share": share}, aquarium, 6) for share in (0.0, 1.0))
    assert all(many >= few for many, few in zip(crowded, plain, strict=True)) and sum(crowded) > sum(plain)
    mixed = things_in({**common, "empty_share": 0.5, "crowded_share": 0.5}, aquarium, 6)
    assert all(count in (0, many) for count, many in zip(mixed, crowded, strict=True)) and 0 < sum(mixed) < sum(crowded)


MEADOW = {
    "name": "meadow",
    "terrain": {"source": "noise", "size_m": [16, 16], "spacing_m": 1, "bed_depth_m": 6},
    "cover": [
        {"kind": "seagrass", "name": "grass", "density_per_m2": 6, "size_m": [0.1, 0.2], "seed": 1},
        {"kind": "starfish", "name": "star", "density_per_m2": 0.2, "size_m": [0.15, 0.3], "seed": 2},
    ],
    "life": [{"kind": "school", "name": "herring", "count": 80, "size_m": [0.2, 0.3], "position_m": [0, 0, -3]}],
    "vehicles": [{"name": "rov", "model": "rov"}],
}


@pytest.mark.parametrize(("look_at", "named"), [("starfish", "star"), ("fish", "herring"), ("herring", "herring")])
def test_a_covered_world_has_pictures_with_and_without_a_class(look_at: str, named: str, tmp_path: Path) -> None:
    """The world is given by its content; starfish are few, grass is everywhere."""
    options = {"size": (160, 120), "write": ("boxes",), "look_at": look_at, "distance_m": (0.8, 2.0), "workers": 0}
    for share, least in ((0.0, 1), (1.0, 0)):
        out = tmp_path / f"{share}"
        uwsim.make_dataset(MEADOW, out, 3, empty_share=share, min_pixels=1, val_share=0.0, **options)
        lines = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
        things = json.loads((out / "annotations/instances_train.json").read_text())["annotations"]
        seen = [{thing["name"] for thing in things if thing["image_id"] == k} for k in range(3)]
        assert all((named in names) == bool(least) for names in seen), seen
        assert [line["empty"] for line in lines] == [not least] * 3
        assert {line["target"] for line in lines} == ({named} if least else {"terrain"})
    assert "grass" in set.union(*seen)


def test_each_frame_depends_on_its_number_alone(aquarium: Path) -> None:
    spec = DatasetSpec(scenario=str(aquarium), n=4, size=(16, 12), write=("depth",))
    one, other = Studio(spec, 1), Studio(spec, 2)
    several = [one.viewpoint(number) for number in range(4)]
    alone = other.viewpoint(3)
    assert np.array_equal(several[3].position_m, alone.position_m)
    assert several[3].target == alone.target
    assert one.time_ns(3) == other.time_ns(3)


@pytest.mark.parametrize("in_sequence", [False, True])
def test_the_split_has_its_share_and_no_frame_twice(in_sequence: bool) -> None:
    for count in (1, 7, 40, 1000):
        for share in (0.0, 0.1, 0.25, 1.0):
            splits = split_of_frames(count, share, 3, in_sequence=in_sequence)
            assert len(splits) == count
            assert splits.count("val") == round(share * count)
            assert set(splits) <= {"train", "val"}
    changes = np.count_nonzero(np.diff(np.array(split_of_frames(1000, 0.2, 3, in_sequence=in_sequence)) == "val"))
    assert changes <= 8 if in_sequence else changes > 100


def test_run_lengths_are_undone_by_counting() -> None:
    random = np.random.default_rng(1)
    for share in (0.0, 0.3, 1.0):
        mask = random.random((7, 5)) < share
        runs = run_lengths(mask)
        values = np.arange(len(runs["counts"])) % 2
        assert np.array_equal(np.repeat(values, runs["counts"]).reshape(mask.shape, order="F").astype(bool), mask)
    assert bounds(np.eye(3, 4, dtype=bool)) == [0, 0, 3, 3]
