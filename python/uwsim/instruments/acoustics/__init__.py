"""Sound between two points in layered water: every arrival with its time, level and angles.

found = arrivals([(0, 1480), (100, 1530)], source_depth_m=20, receiver_depth_m=60, range_m=1000, bottom="sand")
found.time_s, found.level_db, found.surface_bounces
"""

from uwsim.instruments.acoustics.layered_water import SEABEDS, Arrivals, arrivals, seabed_backscatter_db

__all__ = ["SEABEDS", "Arrivals", "arrivals", "seabed_backscatter_db"]
