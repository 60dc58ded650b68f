"""Handlers of the page's service calls, those of the scene editor and of the instructor included."""
