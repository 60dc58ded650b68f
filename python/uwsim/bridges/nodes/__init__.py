"""Clients of a rosbridge server: a node that subscribes, publishes and calls, over a WebSocket."""
