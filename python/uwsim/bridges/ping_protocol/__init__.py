"""Blue Robotics' ping protocol: a Ping1D and a Ping360 for programs that know the real ones."""
