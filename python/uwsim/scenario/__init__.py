"""Scenarios: reading YAML files (`read`), validating them (`spec`) and converting them to core objects (`build`)."""

from uwsim.scenario.build.craft import ControlSettings, control_settings
from uwsim.scenario.build.hull import RigidBody, rigid_body, vehicle_hull
from uwsim.scenario.build.station import start_pose
from uwsim.scenario.build.terrain import Terrain, build_terrain
from uwsim.scenario.build.world import build_world
from uwsim.scenario.load import AnyScenario, load, packaged_scenarios
from uwsim.scenario.read.errors import RepairWarning, ScenarioError
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.mesh_repair import closed_mesh
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.survey import Survey
from uwsim.scenario.spec.vehicle import VehicleModel, load_vehicle
from uwsim.scenario.spec.vehicle_entry import VehicleEntry

__all__ = [
    "AnyScenario",
    "ControlSettings",
    "RepairWarning",
    "RigidBody",
    "Scenario",
    "ScenarioError",
    "Survey",
    "Terrain",
    "VehicleEntry",
    "VehicleModel",
    "build_terrain",
    "build_world",
    "closed_mesh",
    "control_settings",
    "load",
    "load_mesh",
    "load_vehicle",
    "packaged_scenarios",
    "rigid_body",
    "start_pose",
    "vehicle_hull",
]
