"""Scenarios from the robot and world descriptions of other simulators: SDF, URDF, Stonefish's and HoloOcean's."""
