"""Reads scenes of the Unity engine, as published with simulators that were built on it."""
