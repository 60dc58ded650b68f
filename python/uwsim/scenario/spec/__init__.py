"""The contents of a scenario: one pydantic model per concept, with the range and unit of each value."""
