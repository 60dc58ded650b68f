"""What `uwsim map` does with finished maps: tell, convert, score, draw, compare and cut them."""
