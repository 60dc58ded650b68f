"""Readers of text from outside: one each for JSON, CSV and YAML; exchange has XML's.

Each limits the size, and raises ValueError with the file's name, the line, the value and the rule. A lint forbids other
readers of these formats (pyproject.toml).
"""
