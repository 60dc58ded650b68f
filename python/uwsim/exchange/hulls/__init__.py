"""A hull that comes as a mesh alone: the draft of its vehicle, from textbook estimates."""
