"""Systems aboard a vehicle that steer it: MOOS and IMC."""
