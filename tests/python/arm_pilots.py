"""Bad pilots of the exercises for a gripper, and where things are, by the briefs; test_arm_by_keys.py has good ones."""

import math

from uwsim.missions import goto, hold

JAWS_M = (0.44, -0.10)  # ahead and up: the middle between the jaws, on the vehicle
CLOSE, OPEN = 0.04, -0.04


def vehicle_at(place, heading_rad=0.0):
    """Return where the vehicle is while the middle between its jaws is at a place."""
    x, y, z = place
    return (x - JAWS_M[0] * math.cos(heading_rad), y - JAWS_M[0] * math.sin(heading_rad), z - JAWS_M[1])


def jaws_to(vehicle, place, *, heading_rad=0.0, speed_m_s=0.3, for_s=3.0):
    """Bring the middle between the jaws near a place, and then exactly to it."""
    at = vehicle_at(place, heading_rad)
    yield from goto(vehicle, at, heading_rad=heading_rad, within_m=0.1, speed_m_s=speed_m_s)
    yield from hold(vehicle, for_s, position_world_m=at, heading_rad=heading_rad)


def jaws_along(vehicle, begin, end, *, for_s, heading_rad=0.0):
    """Move the middle between the jaws evenly from one place to another."""
    steps = round(for_s / 0.1)
    for k in range(1, steps + 1):
        place = [a + (b - a) * k / steps for a, b in zip(begin, end, strict=True)]
        at = vehicle_at(place, heading_rad)
        yield from hold(vehicle, 0.1, position_world_m=at, heading_rad=heading_rad)


def drive_jaws(vehicle, place, speed_m_s, *, for_s=2.5, heading_rad=0.0):
    """Close or open the jaws, which keep pressing, and stay."""
    vehicle.set_joints(speeds={"left": speed_m_s, "right": speed_m_s})
    at = vehicle_at(place, heading_rad)
    yield from hold(vehicle, for_s, position_world_m=at, heading_rad=heading_rad)


def pull_the_pin(vehicle, console):
    """Take the grip of a console (a prop in the world), draw its pin, let go, and back off."""
    ahead = math.radians(console.yaw_deg + 180.0)
    far, grip, drawn = (console.in_world((x_m, 0.0, 1.0)) for x_m in (0.6, 0.22, 0.47))
    yield from jaws_to(vehicle, far, heading_rad=ahead, for_s=6.0)
    yield from jaws_along(vehicle, far, grip, for_s=8.0, heading_rad=ahead)
    yield from drive_jaws(vehicle, grip, CLOSE, heading_rad=ahead)
    yield from jaws_along(vehicle, grip, drawn, for_s=10.0, heading_rad=ahead)
    yield from drive_jaws(vehicle, drawn, OPEN, heading_rad=ahead)
    yield from jaws_along(vehicle, drawn, far, for_s=4.0, heading_rad=ahead)


SPINDLE_M, LEVER_M = (2.3, 1.4), -3.61


def before_the_lever(angle_deg, radius_m=0.24, before_m=0.07):
    """Return where the jaws are, and the heading, to push the lever, which has turned by an angle from the south."""
    angle = math.radians(angle_deg)
    x = SPINDLE_M[0] + radius_m * math.sin(angle) - before_m * math.cos(angle)
    y = SPINDLE_M[1] - radius_m * math.cos(angle) - before_m * math.sin(angle)
    return (x, y, LEVER_M), angle


def push_at_the_spindle(vehicle):
    """Pushes where the lever has no arm."""
    place, _ = before_the_lever(0, radius_m=0.0, before_m=0.3)
    yield from jaws_to(vehicle, place)
    yield from jaws_along(vehicle, place, before_the_lever(0, radius_m=0.0)[0], for_s=10.0)
    yield from hold(vehicle, 10.0)


GRIP_M = (2.78, 0.5, -3.6)


def pull_without_a_grip(vehicle):
    """Goes there and back with the jaws open."""
    ahead = (GRIP_M[0] - 0.3, *GRIP_M[1:])
    yield from jaws_to(vehicle, ahead)
    yield from jaws_along(vehicle, ahead, GRIP_M, for_s=6.0)
    yield from jaws_along(vehicle, GRIP_M, ahead, for_s=6.0)


SAMPLE_M, BASKET_M = (1.6, -1.0, -4.147), (1.6, -2.2, -4.4)


def drop_the_sample(vehicle):
    """Lets go of it half way."""
    ahead, above = (SAMPLE_M[0] - 0.3, *SAMPLE_M[1:]), (*SAMPLE_M[:2], -3.75)
    yield from jaws_to(vehicle, ahead)
    yield from jaws_along(vehicle, ahead, SAMPLE_M, for_s=6.0)
    yield from drive_jaws(vehicle, SAMPLE_M, CLOSE)
    yield from jaws_along(vehicle, SAMPLE_M, above, for_s=6.0)
    yield from drive_jaws(vehicle, above, OPEN, for_s=5.0)


TAIL_M, SOCKET_M = (1.53, -0.2, -3.578), (2.75, -0.204, -3.6)  # the jaws, when the plug rests and when it is mated


def plug_beside_the_socket(vehicle):
    """Takes the plug, and lets go of it without looking for the socket."""
    ahead, above = (TAIL_M[0] - 0.3, *TAIL_M[1:]), (*TAIL_M[:2], -3.4)
    yield from jaws_to(vehicle, ahead)
    yield from jaws_along(vehicle, ahead, TAIL_M, for_s=6.0)
    yield from drive_jaws(vehicle, TAIL_M, CLOSE)
    yield from jaws_along(vehicle, TAIL_M, above, for_s=6.0)
    yield from drive_jaws(vehicle, above, OPEN, for_s=5.0)


ARM_PILOTS = {
    "valve": (None, push_at_the_spindle),
    "pin": (None, pull_without_a_grip),
    "sample": (None, drop_the_sample),
    "wet-mate": (None, plug_beside_the_socket),
}
