"""Scenarios: what a YAML file may say, how it is checked, and the world that is built from it."""

from uwsim.scenario.build import build_world, start_pose
from uwsim.scenario.closing import closed_mesh
from uwsim.scenario.errors import RepairWarning, ScenarioError
from uwsim.scenario.loading import load, packaged_scenarios
from uwsim.scenario.meshes import load_mesh
from uwsim.scenario.schema import Scenario, Survey
from uwsim.scenario.terrain import Terrain, build_terrain
from uwsim.scenario.vehicle_model import VehicleModel
from uwsim.scenario.vehicles import RigidBody, load_vehicle, rigid_body, vehicle_hull

__all__ = [
    "RepairWarning",
    "RigidBody",
    "Scenario",
    "ScenarioError",
    "Survey",
    "Terrain",
    "VehicleModel",
    "build_terrain",
    "build_world",
    "closed_mesh",
    "load",
    "load_mesh",
    "load_vehicle",
    "packaged_scenarios",
    "rigid_body",
    "start_pose",
    "vehicle_hull",
]
