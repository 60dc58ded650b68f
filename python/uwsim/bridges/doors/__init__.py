"""The sockets on which uwsim receives: who may enter, how many, and how fast."""
