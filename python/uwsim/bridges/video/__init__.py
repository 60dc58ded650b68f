"""A camera's pictures as an H.264 stream."""
