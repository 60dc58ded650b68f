"""Tests for cover: layers of pieces on the bed, from the file to pings, pictures and scores."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import uwsim
from uwsim import _core
from uwsim.scenario import load
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.cover import COVERS

SCENE = """
name: covered
terrain: {{source: noise, size_m: [24, 24], spacing_m: 0.5, bed_depth_m: 6, hill_height_m: 0.5, hill_wavelength_m: 12}}
cover:
{layers}
vehicles:
  - {{name: rov, model: rov, start: {{position_m: [0, 0, -2]}}, sonar: {{model: 2, tilt_deg: 60}}}}
"""
ROCKS = "  - {kind: rock, name: rocks, density_per_m2: 4, size_m: [0.1, 0.8], seed: 3}\n"
STARS = "  - {kind: starfish, name: stars, density_per_m2: 1, size_m: [0.2, 0.3]}\n"


def written(folder: Path, layers: str) -> Path:
    path = folder / "covered.yaml"
    path.write_text(SCENE.format(layers=layers))
    return path


def pieces(sim: uwsim.Simulator) -> list[bytes]:
    return [np.asarray(part).tobytes() for part in sim.around().scene.cover_in([-12, -12], [12, 12])]


@pytest.mark.parametrize("kind", [name for name in COVERS.models(own=True) if name != "mesh"])
def test_meshes_of_each_kind_are_small_and_of_size_one(kind: str) -> None:
    model = COVERS.models(own=True)[kind]
    made = model(kind=kind, name="layer", density_per_m2=1, size_m=(0.1, 0.2)).meshes(np.random.default_rng(1))
    for vertices, triangles in made:
        assert np.isfinite(vertices).all() and triangles.max() < len(vertices) <= 3000
        extent = np.ptp(vertices, axis=0)
        assert extent.max() == pytest.approx(1.0) or extent[2] == pytest.approx(1.0)
    assert any(not np.array_equal(made[0][0], other[0]) for other in made[1:])


def test_sonar_camera_and_distances_perceive_pieces(tmp_path: Path) -> None:
    with uwsim.Simulator(written(tmp_path, ROCKS + STARS), threads=2) as sim:
        sim.rov.release()
        assert sim.label_names == ["nothing", "terrain", "rocks", "stars", "rov"] == list(sim.strengths_db)
        labels = sim.rov.sonar.ping().labels
        assert 2 in labels and 1 in labels
        sim.rov.place((0.0, 0.0, -3.0), (0.0, np.sin(0.6), 0.0, np.cos(0.6)))
        frame = sim.rov.cameras["front"].resized(160, 120).capture()
        assert frame.class_names[-2:] == ("rock", "starfish")
        assert ((frame.pieces != 0) == np.isin(frame.labels, (2, 3))).all()
        assert len(np.unique(frame.pieces[frame.labels == 2])) > 10
        positions, sizes, own, numbers = sim.around().scene.cover_in([-12, -12], [12, 12])
        assert set(np.unique(frame.pieces)) <= {0, *numbers.tolist()}
        inside = np.asarray(positions)[(own == 2) & (sizes > 0.3)]
        assert (sim.around().scene.distance_m(inside) < 0.5 * sizes[(own == 2) & (sizes > 0.3)]).all()


def test_places_depend_on_the_layers_seed_alone(tmp_path: Path) -> None:
    layers = ROCKS, STARS + ROCKS, ROCKS.replace("seed: 3", "seed: 4")
    found = []
    for seed, layer in enumerate(layers):
        with uwsim.Simulator(written(tmp_path, layer), seed=seed) as sim:
            found.append(pieces(sim))
    with uwsim.Simulator(written(tmp_path, ROCKS), seed=9) as again:
        assert pieces(again) == found[0]
    assert len({parts[0] for parts in found}) == 3


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("density_per_m2: 4", "density_per_m2: -1", ".density_per_m2 = -1 1/m2: must be in [0, 1000]"),
        ("density_per_m2: 4", "density_per_m2: .nan", ".density_per_m2"),
        ("kind: rock", "kind: rok", "rock"),
        ("size_m: [0.1, 0.8]", "size_m: [0.8, 0.1]", "must not exceed its second"),
        ("kind: rock", "kind: mesh, file: no.obj", "no such file"),
        ("name: rocks", "name: rov", "is already in use"),
        ("seed: 3", "sed: 3", "seed"),
    ],
)
def test_mistakes_are_refused_with_their_place(tmp_path: Path, before: str, after: str, message: str) -> None:
    path = written(tmp_path, ROCKS.replace(before, after))
    with pytest.raises(ScenarioError) as refused:
        load(path)
    assert message in str(refused.value) and "covered.yaml" in str(refused.value)


def test_a_users_mesh_is_a_kind_of_cover(tmp_path: Path) -> None:
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 6\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    layer = "  - {kind: mesh, name: wedges, file: wedge.obj, density_per_m2: 1, size_m: [0.3, 0.3]}\n"
    with uwsim.Simulator(written(tmp_path, layer)) as sim:
        positions, sizes, labels, _ = sim.around().scene.cover_in([-12, -12], [12, 12])
        assert len(positions) > 300 and set(labels.tolist()) == {2} and np.allclose(sizes, 0.3)
        top = np.add(positions[0], (0.0, 0.0, 5.0))
        hit = sim.around().scene.cast([top], [[0.0, 0.0, -1.0]], 10.0)
        assert hit.labels[0] in (1, 2)


KELP = "  - {kind: kelp, name: kelp, density_per_m2: 2, size_m: [1, 2], seed: 3}\n"
WAVES = "water: {surface: {kind: airy, amplitude_m: 0.3, period_s: 5, heading_deg: 30}}\n"


def test_plants_sway_with_the_waves_for_all_instruments_and_repeat(tmp_path: Path) -> None:
    path = written(tmp_path, KELP)
    path.write_text(path.read_text() + WAVES)

    def seen(threads: int) -> list[tuple[bytes, ...]]:
        found = []
        down = np.tile([0.3, 0.1, -1.0] / np.sqrt(1.1), (400, 1))
        eyes = np.column_stack([np.random.default_rng(1).uniform(-8, 8, (400, 2)), np.full(400, -2.0)])
        with uwsim.Simulator(path, threads=threads) as sim:
            sim.rov.release()
            for _ in range(3):
                sim.rov.place((0.0, 0.0, -3.0), (0.0, np.sin(0.3), 0.0, np.cos(0.3)))
                frame = sim.rov.cameras["front"].resized(80, 60).capture(geometry_only=True)
                rays = sim.around().scene.cast(eyes, down, 20.0)
                found.append(
                    (rays.ranges_m.tobytes(), sim.rov.sonar.ping().ranges_m.tobytes(), frame.depth_m.tobytes())
                )
                sim.step(50)
        return found

    one, two = seen(1), seen(2)
    assert one == two
    assert all(len({part[k] for part in one}) == 3 for k in range(3))
    path.write_text(path.read_text().replace("seed: 3}", "seed: 3, leans_at_m_s: null}"))
    assert len({part[0] for part in seen(1)}) == 1


def test_a_world_without_cover_has_no_pieces() -> None:
    world = _core.World()
    world.set_terrain(np.full((5, 5), -3.0, np.float32), 1.0, (-2.0, -2.0))
    positions, _, labels, _ = _core.RayScene(world).cover_in([-2, -2], [2, 2])
    assert len(positions) == len(labels) == 0


@pytest.mark.parametrize("kind", ["rock", "coral", "mesh", "coral, form: fan", "mesh, solid: false", "urchin", "kelp"])
def test_bodies_rest_on_solid_kinds_and_sink_through_others(tmp_path: Path, kind: str) -> None:
    is_solid = kind in ("rock", "coral", "mesh")
    file = ", file: meshes/diver.glb" if kind.startswith("mesh") else ""
    layer = f"  - {{kind: {kind}{file}, name: layer, density_per_m2: 8, size_m: [0.5, 0.6]}}\n"
    shape = "{kind: box, name: crate, position_m: [0, 0, -4.5], size_m: [1, 1, 0.4]}"
    path = written(tmp_path, layer)
    path.write_text(
        path.read_text().replace("hill_height_m: 0.5", "hill_height_m: 0.0")
        + f"objects:\n  - {{shape: {shape}, mass_kg: 900}}\n"
    )
    with uwsim.Simulator(path) as sim:
        sim.advance(8.0)
        height_m = sim.objects["crate"].pose.position_world_m[2] + 6
    assert (height_m > 0.25) == is_solid
