"""Pilots of the exercises at wreck, reef, kelp, harbour, fish farm, wind turbine and on a tether: one good, one bad."""

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


def beside_the_diver(vehicle):
    """Swims along, 3 m to the diver's right, with the nose to the diver, and then to the sinker."""
    yield from goto(vehicle, (-4.0, -14.6, -6.0), heading_rad=math.radians(72), speed_m_s=0.35)
    yield from goto(vehicle, (-9.0, -13.0, -4.6), speed_m_s=0.8)
    yield from goto(vehicle, (-7.0, -6.0, -5.0), speed_m_s=0.8)
    yield from goto(vehicle, (-2.8, -1.6, -6.4), heading_rad=math.radians(30), speed_m_s=0.6)
    yield from hold(vehicle, 4.0)


def to_the_sinker(vehicle):
    """Does not wait for the diver."""
    yield from goto(vehicle, (-4.0, -14.0, -5.0), heading_rad=math.radians(180), speed_m_s=0.8)


def along_the_damaged_pipe(vehicle):
    """Flies 1.5 m above the pipe, looking ahead."""
    for x, y, z in (
        (-45, 18.1, -5.2), (-41, 18.8, -5.4), (-38.5, 19.2, -6.2), (-36, 19.5, -6.2), (-30, 20.6, -6.4),
        (-24, 21.6, -5.8), (-18, 22.6, -5.2), (-10, 24, -4.9), (-4, 22.9, -6.5), (0, 22.0, -8.8), (4.3, 21.2, -9.3),
    ):  # fmt: skip
        yield from goto(vehicle, (x, y, z), within_m=0.4, speed_m_s=0.5)


def past_the_pipe(vehicle):
    """Sees the first damage only."""
    for place in ((-45, 18.1, -5.2), (-41, 18.8, -5.4), (-38.5, 19.2, -6.2)):
        yield from goto(vehicle, place, within_m=0.6, speed_m_s=0.6)


def for_the_seal(vehicle):
    for place in ((-14.5, -4, -9.0), (-14, -4, -9.4), (-9.8, -4, -9.1)):
        yield from goto(vehicle, place, within_m=0.3, speed_m_s=0.4)
    yield from goto(vehicle, (-9.5, 1.5, -5.5), heading_rad=math.radians(120))
    yield from hold(vehicle, 110.0)


def away_from_the_seal(vehicle):
    """Flies along the transect, and turns away."""
    for place in ((-14.5, -4, -9.0), (-14, -4, -9.4), (-9.8, -4, -9.1)):
        yield from goto(vehicle, place, within_m=0.3, speed_m_s=0.4)
    yield from turn_to(vehicle, 0.0)


def along_the_quay(vehicle):
    north = math.radians(90)
    for place in ((-8, 15.9, -2.4), (-6, 10.6, -6.2)):
        yield from goto(vehicle, place, heading_rad=north, within_m=0.3, speed_m_s=0.6)
        yield from hold(vehicle, 3.0)
    for place in ((-6, 7.5, -4.5), (2, 7.5, -4.5), (2, 11.6, -6.2)):
        yield from goto(vehicle, place, heading_rad=north, within_m=0.3, speed_m_s=0.6)
    yield from hold(vehicle, 3.0)


def far_from_the_quay(vehicle):
    """Looks at the ladder from where the water hides it."""
    yield from goto(vehicle, (-8, 12, -2.4), heading_rad=math.radians(90))
    yield from hold(vehicle, 3.0)


DIVES = {
    "net-inspection": (around_the_pen, along_the_surface),
    "wreck-dive": (into_the_wreck, over_the_wreck),
    "cable": (along_the_cable, beside_the_cable),
    "tether": (back_along_the_tether, back_by_the_shortest_way),
    "reef-pipeline": (along_the_damaged_pipe, past_the_pipe),
    "reef-diver": (beside_the_diver, to_the_sinker),
    "kelp-seal": (for_the_seal, away_from_the_seal),
    "quay": (along_the_quay, far_from_the_quay),
}
