"""The complete default survey achieves the promised values."""

from uwsim import Simulator
from uwsim.flight.record import DONE
from uwsim.flight.survey import fly_survey
from uwsim.scoring.map_score import score_map


def test_the_lake_survey_meets_its_promises() -> None:
    sim = Simulator("lake")
    occupancy, record = fly_survey(sim)
    assert record.ended_because == DONE
    assert record.collisions == 0
    assert record.simulated_s >= 20 * 60
    assert sim.step_s <= 0.005
    assert record.ping_count >= 10 * record.simulated_s - 1
    width_m, height_m = record.area_world_m.max(axis=0) - record.area_world_m.min(axis=0)
    assert width_m >= 150
    assert height_m >= 100
    score = score_map(
        sim.world,
        occupancy.occupied_voxels(),
        occupancy.resolution_m,
        record.path_world_m,
        record.area_world_m,
        record.range_max_m,
    )
    assert score.coverage >= 0.95
    assert score.distance_p95_m < 0.5
    gate = sim.world.label_names.index("gate_main")
    vertices, triangles, labels = sim.world.surface_mesh()
    top_m = vertices[triangles[labels == gate]].reshape(-1, 3)
    top_m = top_m[top_m[:, 2].argmax()]
    seen = occupancy.occupied_voxels()
    assert (abs(seen - top_m).max(axis=1) < 1.0).any(), "the gate's bar is in the map"
