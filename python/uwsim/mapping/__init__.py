"""Occupancy maps that match OctoMap's bit for bit: octree, probabilities and files.

world = OccupancyMap(resolution_m=0.2)
world.insert(rov.sonar.ping())
world.write("lake.bt")
world = OccupancyMap.read("lake.bt")
"""

from uwsim.mapping.body import body_points, poses_along
from uwsim.mapping.distance_field import DistanceField
from uwsim.mapping.frontier import Frontier, frontiers
from uwsim.mapping.map_options import ENGINES, INSTRUCTION_SETS, InstructionSet, MapEngine, OccupancyModel, OnOutside
from uwsim.mapping.occupancy_map import MapFormat, OccupancyMap
from uwsim.mapping.query_results import (
    Cubes,
    MapChanges,
    MapStatistics,
    OccupancyChanges,
    RayCasts,
    StateGrid,
    VoxelCounts,
)

__all__ = [
    "ENGINES",
    "INSTRUCTION_SETS",
    "Cubes",
    "DistanceField",
    "Frontier",
    "InstructionSet",
    "MapChanges",
    "MapEngine",
    "MapFormat",
    "MapStatistics",
    "OccupancyChanges",
    "OccupancyMap",
    "OccupancyModel",
    "OnOutside",
    "RayCasts",
    "StateGrid",
    "VoxelCounts",
    "body_points",
    "frontiers",
    "poses_along",
]
