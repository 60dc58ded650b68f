"""Parts of obstacles in datasets: what a mask shows lies where the world has the part."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import uwsim
from uwsim.campaigns.datasets.spec import DatasetSpec
from uwsim.campaigns.datasets.studio import Studio

RADIUS_M, BED_M = 0.3, -9.0
SITE = """
name: site
terrain: {source: noise, size_m: [80, 60], spacing_m: 1, bed_depth_m: 9, hill_height_m: 0}
station: {position_m: [-25, -20, 0]}
obstacles:
  - kind: pipeline
    name: pipe
    points_m: [[-30, 0], [0, 0], [25, 15]]
    radius_m: 0.3
    condition:
      features:
        - {kind: damage, at_m: 15, clock_h: 12}
        - {kind: span, at_m: 40, height_m: 0.6}
        - {kind: debris, at_m: 22}
  - {kind: net, name: pen, position_m: [0, -15, -1], radius_m: 4, depth_m: 5, mesh_m: 0.3, holes: 1, seed: 3}
  - {kind: cylinder, name: pile, position_m: [20, -15, -5], radius_m: 0.4, length_m: 12, growth: {age_years: 3}}
vehicles: [{name: rov, model: rov}]
"""
OPTIONS = {"size": (160, 120), "without": ("wobble", "distortion"), "label_range_m": 12.0}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("world") / "site.yaml"
    path.write_text(SITE)
    return path


def studio_at(site: Path, position_m: tuple[float, float, float], yaw: float) -> Studio:
    studio = Studio(DatasetSpec(scenario=str(site), n=1, write=("parts", "boxes"), **OPTIONS))
    studio.vehicle.place(np.array(position_m), np.array([0, 0, np.sin(yaw / 2), np.cos(yaw / 2)]))
    return studio


def shown(studio: Studio) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """Return, by kind, the mask of each part in view, and the points (n, 3) that its pixels show."""
    frame = studio.picture(0)
    depth_m = np.where(np.isfinite(frame.depth_m), frame.depth_m, 0)[..., None]
    optical = np.concatenate([studio.rays * depth_m, depth_m], axis=-1).reshape(-1, 3)
    points = optical @ frame.world_from_optical[:3, :3].T + frame.world_from_optical[:3, 3]
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for number, mask in studio.part_masks(frame).items():
        found.setdefault(studio.parts.all[number - 1][1].kind, []).append((mask, points[mask.ravel()]))
    return found


def test_pixels_of_pipe_parts_lie_on_them(site: Path) -> None:
    found = shown(studio_at(site, (-15.5, -3.0, -7.6), np.pi / 2))
    (_, damage) = found["damage"][0]
    assert len(damage) > 30
    assert np.abs(damage[:, 0] - -15).max() <= 0.4 + 1e-6, "0.8 m long"
    axis_m = np.array([0.0, BED_M + RADIUS_M * 0.6])
    off_m = np.linalg.norm(damage[:, 1:] - axis_m, axis=1)
    assert off_m.max() < RADIUS_M + 0.01 and np.median(off_m) == pytest.approx(0.88 * RADIUS_M, abs=0.012)
    (_, joint) = found["joint"][0]
    assert np.abs(joint[:, 0] - (-30 + 12.2)).max() <= 0.15 + 1e-6
    (_, anode) = shown(studio_at(site, (-24.0, -3.0, -7.6), np.pi / 2))["anode"][0]
    assert np.abs(anode[:, 0] - (-30 + 6.1)).max() <= 0.25 + 1e-6
    on_anode = np.linalg.norm(anode[:, 1:] - axis_m, axis=1)
    assert np.median(on_anode) == pytest.approx(1.12 * RADIUS_M, abs=0.012)


def test_a_span_behind_a_bend_is_the_pipe_above_the_bed(site: Path) -> None:
    ahead = np.array([25.0, 15.0]) / np.hypot(25, 15)
    middle = 10 * ahead  # 40 m along the line
    eye = (*(middle + 4 * np.array([ahead[1], -ahead[0]])), -7.6)
    (_, span) = shown(studio_at(site, eye, float(np.arctan2(ahead[0], -ahead[1]))))["span"][0]
    along = (span[:, :2] - middle) @ ahead
    assert np.abs(along).max() <= 4 + 1e-6
    assert span[np.abs(along) < 0.3, 2].min() > BED_M + 0.3


def test_a_hole_is_where_rays_pass_the_wall(site: Path) -> None:
    studio = studio_at(site, (0, -15, -3), 0)
    (hole,) = [part for _, part in studio.parts.all if part.kind == "hole"]
    out = (hole.place_m - [0, -15, -1]) * [1, 1, 0] / 4
    studio.vehicle.place(
        hole.place_m - 2.0 * out,
        np.array([0, 0, np.sin(np.arctan2(*out[1::-1]) / 2), np.cos(np.arctan2(*out[1::-1]) / 2)]),
    )
    (mask, _) = shown(studio)["hole"][0]
    frame = studio.picture(0)
    eye = frame.world_from_optical[:3, 3]
    far_m = float((hole.place_m - eye) @ out)
    disc = np.pi * (0.4 * studio.info.k.reshape(3, 3)[0, 0] / far_m) ** 2
    assert mask.sum() == pytest.approx(disc, rel=0.15), "a disc of 0.8 m, seen from the front"
    assert not (frame.labels[mask] == studio.label_names.index("pen")).all()


def test_growth_is_the_pile_under_water(site: Path) -> None:
    found = shown(studio_at(site, (16.5, -15, -4), 0.0))
    frame_mask, points = found["growth"][0]
    assert frame_mask.sum() > 300 and points[:, 2].max() < 0.5


def test_parts_are_in_coco_with_classes_of_their_own(site: Path, tmp_path: Path) -> None:
    out = tmp_path / "data"
    uwsim.make_dataset(
        site, out, 3, workers=0, write=("parts", "classes", "boxes", "rgb", "yolo"), look_at=("damage", "debris"),
        distance_m=(1.0, 3.0), val_share=0.0, pitch_max_deg=60, **OPTIONS
    )  # fmt: skip
    about = json.loads((out / "dataset.json").read_text())
    parts = {part["number"]: part for part in about["parts"]}
    assert {"joint", "anode", "damage", "span", "debris", "hole", "growth"} <= {part["name"] for part in parts.values()}
    train = json.loads((out / "annotations/instances_train.json").read_text())
    names = {each["id"]: each["name"] for each in train["categories"]}
    marked = [each for each in train["annotations"] if "part" in each]
    assert {names[each["category_id"]] for each in marked} >= {"damage"} or {"debris"}
    for each in marked:
        assert (
            names[each["category_id"]] == parts[each["part"]]["name"]
            and each["name"] == parts[each["part"]]["obstacle"]
        )
    for line in map(json.loads, (out / "frames.jsonl").read_text().splitlines()):
        picture = np.asarray(Image.open(out / line["files"]["parts"]))
        assert line["target"] in {parts[number]["name"] for number in np.unique(picture) if number}
