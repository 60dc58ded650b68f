"""Compiled ArduSubs that uwsim starts, flies and compares."""
