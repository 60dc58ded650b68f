"""Films of a recorded run: its states at the times of the frames, and what a camera of the film's sees of them."""
