"""NMEA 0183: sentences of a vehicle's navigation for survey and chart programs."""
