"""The world for the page's 3D view, and what moves in it."""
