"""ROS without ROS: message and service types, messages, and their conversion to and from bytes and plain values."""
