"""The simulator as an application of a MOOS community."""
