"""Readers of YAML, mesh and texture files, whose errors name file, line and rule."""
