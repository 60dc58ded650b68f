"""A recording played to the clients of bridges, without a simulator."""
