"""Pilots of the exercises at the wreck, fish farm and wind turbine and on a tether: a good and a bad one of each."""

import math

from uwsim.missions import goto, hold, turn_to


def around_the_pen(vehicle, depth_m=4.4):
    """Circle the western pen 2 m from its net, with the nose to it."""
    for k in range(19):
        turn = math.radians(210 + 20 * k)
        place = (-9 + 8.2 * math.cos(turn), 8.2 * math.sin(turn), -depth_m)
        yield from goto(vehicle, place, heading_rad=turn + math.pi, within_m=0.6, speed_m_s=0.7)


def along_the_surface(vehicle):
    """Passes the pen once, looking ahead."""
    yield from goto(vehicle, (-9, -9, -1))


def into_the_wreck(vehicle):
    for place in ((1.3, -1.8, -7.2), (0.8, -0.8, -12.8), (1.3, -1.8, -7.2)):
        yield from goto(vehicle, place, heading_rad=math.radians(20), within_m=0.3, speed_m_s=0.4)
    for place in ((4, -9, -7), (22, 1, -8), (20.5, 6.6, -11)):
        yield from goto(vehicle, place, speed_m_s=0.8)
    yield from turn_to(vehicle, math.radians(195))
    yield from hold(vehicle, 3.0)
    for place in ((22, 1, -9), (6, -11, -8), (-16, -16, -8), (-24, -8, -11)):
        yield from goto(vehicle, place, speed_m_s=0.8, within_m=1.0)
    yield from goto(vehicle, (-24.0, -6.2, -11.8))
    yield from turn_to(vehicle, math.radians(10))
    yield from hold(vehicle, 3.0)


def over_the_wreck(vehicle):
    """Looks into the hold from above, and does not enter it."""
    yield from goto(vehicle, (1.3, -1.8, -8.5))


def along_the_cable(vehicle):
    for place in ((26.5, 4, -22.9), (16, 3, -22.9), (12.5, 1.6, -22.9), (9, 0.3, -24.2)):
        yield from goto(vehicle, place, within_m=0.3)
    yield from turn_to(vehicle, math.pi)
    yield from goto(vehicle, (8.7, 0.2, -26.0), heading_rad=math.pi, within_m=0.3)
    yield from hold(vehicle, 3.0)


def beside_the_cable(vehicle):
    """Crosses the cable, and does not follow it."""
    yield from goto(vehicle, (20, 10, -22))


def back_along_the_tether(vehicle):
    """Rounds the pile from the north, and returns by the same way."""
    out = ((-8, 7, -4), (0, 7, -4), (3, 6, -4), (3, 3, -4))
    for place in out:
        yield from goto(vehicle, place, within_m=0.6)
    for place in (*out[2::-1], (-16, 0, -4)):
        yield from goto(vehicle, place, within_m=0.8)


def back_by_the_shortest_way(vehicle):
    """Rounds the pile from the north, and returns south of it."""
    for place in ((-8, 7, -4), (0, 7, -4), (3, 6, -4), (3, 3, -4), (0, 1.5, -4), (-16, 0, -4)):
        yield from goto(vehicle, place, within_m=0.6)


DIVES = {
    "net-inspection": (around_the_pen, along_the_surface),
    "wreck-dive": (into_the_wreck, over_the_wreck),
    "cable": (along_the_cable, beside_the_cable),
    "tether": (back_along_the_tether, back_by_the_shortest_way),
}
