"""Flights that the station has recorded, and their replay."""
