"""Handlers of the page's service calls, those of the scene editor included."""
