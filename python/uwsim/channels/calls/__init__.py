"""The services of the simulator and its vehicles, and the requests that they receive."""
