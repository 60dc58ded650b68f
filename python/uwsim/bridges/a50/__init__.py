"""Water Linked's DVL protocol: the vehicle's DVL as an A50 for programs that know the real one."""
