"""The start screen: its choice of a scenario, its preview, and the simulator prepared meanwhile."""
