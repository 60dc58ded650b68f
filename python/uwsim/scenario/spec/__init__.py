"""The contents of a scenario: a pydantic model for each concept, with the range and unit of each value."""
