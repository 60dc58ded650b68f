"""The 3D view in a real browser: meshes in their colours; those before the vehicle are transparent, and only these."""

import io
import json
import urllib.request

import numpy as np
import pytest
import trimesh

from browser import desk, until, when
from uwsim import _core

NEAR = 0.97  # of the way to the vehicle, as in map3d/sight.js
PLACES = {
    "lake": None,  # in its dock, within the station
    "wreck": [0.8, -0.8, -12.8],  # in the hold
}
LOOK = """([eye]) => {
  const { scene } = station;
  const { position } = scene.vessels.get('rov').group;
  scene.aim(position.clone().fromArray(eye).add(position), position);
  return position.toArray();
}"""
COLOURS = """() => {
  const found = [];
  station.scene.scene.traverse(({ geometry, parent }) => {
    const { color } = parent === station.scene.scene ? {} : (geometry?.attributes ?? {});
    for (let k = 0; k < (color?.count ?? 0); k += 1) found.push([color.getX(k), color.getY(k), color.getZ(k)].join());
  });
  return [...new Set(found)].map((each) => each.split(',').map(Number));
}"""
FADED = """() => {
  let count = 0;
  const now = performance.now();
  globalThis.later = (globalThis.later ?? 0) + 1000; // than the scene's last look, without waiting for the next one
  performance.now = () => now + globalThis.later;
  station.scene.picture(() => 0);
  delete performance.now;
  station.scene.scene.traverse((part) => {
    if (part.isMesh && part.parent !== station.scene.scene && part.material.opacity === 0.2) count += 1;
  });
  return count;
}"""


def get(url: str) -> bytes:
    with urllib.request.urlopen(url) as answer:
        return answer.read()


@pytest.mark.parametrize(("scenario", "place_m"), PLACES.items(), ids=list(PLACES))
def test_meshes_have_their_files_colours_and_those_before_the_vehicle_are_transparent(
    browser, tmp_path, scenario, place_m
):
    with desk(browser, tmp_path, scenario, speed=0.5) as here:
        live = here.station.present().live
        if place_m is not None:
            live.rov.undock()
            live.command("place", vehicle="rov", position_world_m=place_m).result()
        live.pause()
        world = _core.World()
        scene = json.loads(get(here.url + "/scene/scene.json"))
        parts, sim = scene["meshes"], live.simulator
        true_m = sim.rov.pose.position_world_m + np.subtract(scene["station_m"], sim.scenario.station.position_m)
        for k, part in enumerate(parts):
            mesh = trimesh.load(io.BytesIO(get(here.url + part["url"])), file_type="glb", force="mesh")
            world.add_solid(f"part_{k}", np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.uint32))
        rays = _core.RayScene(world)
        page = here.open()
        when(page, "globalThis.station?.scene?.vessels.get('rov')?.group.children.length > 1")
        when(page, f"station.scene.scene.children.length >= {len(parts) + 4}")
        page.evaluate("station.views.enlarge('scene')")
        until(lambda: np.linalg.norm(page.evaluate(LOOK, [[9.0, 0.0, 9.0]]) - true_m) < 0.5, "the vehicle's place")
        seen = set()
        for angle in np.radians(np.arange(0.0, 360.0, 45.0)):
            for up_m in (0.5, 9.0):
                eye_m = np.array([14.0 * np.cos(angle), 14.0 * np.sin(angle), up_m])
                target_m = np.array(page.evaluate(LOOK, [eye_m.tolist()]))
                far_m = np.linalg.norm(eye_m)
                hit_m = rays.cast((target_m + eye_m)[None], -eye_m[None] / far_m, far_m).ranges_m[0]
                if abs(hit_m / far_m - NEAR) < 0.01:
                    continue  # at the edge of what counts
                hides = bool(hit_m < NEAR * far_m)
                assert (page.evaluate(FADED) > 0) == hides, f"{scenario}: {np.degrees(angle):.0f} deg, {up_m} m up"
                seen.add(hides)
        assert seen == {True, False}
        if scenario == "lake":
            station = trimesh.load_scene(sim.scenario.station.mesh, process=False).dump(concatenate=False)
            own = sorted({tuple(part.visual.material.main_color[:3] / 255.0) for part in station})
            until(lambda: len(page.evaluate(COLOURS)) == len(own) > 4, "the station's colours")
            np.testing.assert_allclose(sorted(page.evaluate(COLOURS)), own, atol=2.5 / 255.0)
    assert not here.complaints
