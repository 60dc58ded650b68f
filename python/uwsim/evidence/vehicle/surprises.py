"""Finds likely oversights in a valid vehicle file, such as a hull that rests upside down or a propeller far from it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from uwsim.evidence.vehicle.figures import NO_LEVER_M, VehicleFigures
from uwsim.evidence.vehicle.trials import RUN_S, TILT_DEG, StraightRun
from uwsim.evidence.vehicle.views import Mount
from uwsim.scenario.build.scale import size_text

REST_TILT_DEG = 5.0
"""Tilt at rest beyond which a warning is given."""
AWAY_LENGTHS = 0.5
"""Distance of a mount from the hull's box, as a share of its longest side, beyond which a warning is given."""
OFF_DOWN_DEG = 60.0
"""Angle of a DVL from straight down beyond which a warning is given: two of its beams are then above the horizon."""
BLOCKED_SHARE = 0.5
GYRATION_SHARES = (0.3, 3.0)
"""Limits of a radius of gyration relative to that of the hull as a solid; no distribution of parts explains others."""
GROWTH_1_S = 0.05
"""Growth rate of a yaw disturbance beyond which a warning is given; a helmsman needs 20 s to notice a slower one."""
EXTREME_SHARE = 0.2
"""Ratio of net buoyancy to weight, in fresh and in sea water, beyond which trimming cannot help."""
FRESH_KG_M3, SEA_KG_M3 = 1000.0, 1026.0

Found = tuple[tuple[str | int, ...], str]


def vehicle_surprises(figures: VehicleFigures) -> Iterator[Found]:
    """Yield keys in the vehicle file, each with a sentence about a likely oversight."""
    at_rest = [*_of_attitude(figures)]
    yield from at_rest
    if not at_rest:
        yield from _of_straight_run(figures)
    yield from _of_inertia(figures)
    yield from _of_steering(figures)
    for mount in figures.mounts:
        yield from ((_keys(mount), text) for text in _of_mount(mount, figures))


def buoyancy_surprises(figures: VehicleFigures) -> Iterator[Found]:
    """Yield warnings about buoyancy that apply in any water, since a vehicle file does not specify the water."""
    density = figures.density_kg_m3
    if figures.metacentric_m is not None:
        return
    if density > SEA_KG_M3 / (1.0 - EXTREME_SHARE):
        yield (), f"its mean density is {density:.0f} kg/m3: it sinks like a stone in any water"
    elif density < FRESH_KG_M3 / (1.0 + EXTREME_SHARE):
        yield (), f"its mean density is {density:.0f} kg/m3: it floats like a cork on any water"


def _of_attitude(figures: VehicleFigures) -> Iterator[Found]:
    lever_m = figures.righting_lever_m
    if figures.metacentric_m is not None:
        yield from _of_boat(figures, figures.metacentric_m)
    elif lever_m < -NO_LEVER_M:
        yield (
            ("centre_of_mass_m",),
            f"its centre of mass is {-lever_m:.3g} m above its centre of buoyancy: left alone it hangs upside down",
        )
    elif figures.nose_down_deg is not None and figures.roll_to_starboard_deg is not None:
        pitch, roll = figures.nose_down_deg, figures.roll_to_starboard_deg
        if max(abs(pitch), abs(roll)) > REST_TILT_DEG:
            x, y, _ = np.subtract(figures.centre_of_mass_m, figures.centre_of_buoyancy_m)
            yield (
                ("centre_of_mass_m",),
                f"left alone it rests {attitude_text(pitch, roll)}: its centre of mass is {x:+.3g} m ahead and "
                f"{y:+.3g} m to port of its centre of buoyancy, {lever_m:.3g} m below",
            )


def _of_boat(figures: VehicleFigures, metacentric_m: tuple[float, float]) -> Iterator[Found]:
    for way, height_m in zip(("over to a side", "by the bow or the stern"), metacentric_m, strict=True):
        if height_m < NO_LEVER_M:
            yield (
                ("centre_of_mass_m",),
                f"as it floats, its metacentre is {-height_m:.3g} m below its centre of mass: it falls {way}",
            )
    pitch, roll = figures.nose_down_deg or 0.0, figures.roll_to_starboard_deg or 0.0
    if min(metacentric_m) >= NO_LEVER_M and max(abs(pitch), abs(roll)) > REST_TILT_DEG:
        yield ("centre_of_mass_m",), f"left alone it floats {attitude_text(pitch, roll)}"


def _of_straight_run(figures: VehicleFigures) -> Iterator[Found]:
    run = figures.straight
    if run is None:
        if "surge" in figures.drives:
            yield (), "at full surge without control its motion diverges: see its damping, mass and inertia"
        return
    if run.tilt_without_munk_deg is None:
        return
    what = f"after {RUN_S:g} s at full surge without control it is {straight_text(run)}"
    if run.tilt_without_munk_deg > TILT_DEG:
        yield ("thrusters",), f"{what}: does the thrust pass above or below its centre of mass and drag?"
    else:
        yield (
            ("munk_share",),
            f"{what}; without the Munk moment it would tilt by {run.tilt_without_munk_deg:.0f} deg. That moment grows "
            "with the speed squared and the added mass in heave and sway beyond surge. Tail fins counter it, or trim "
            "weights that lower the centre of mass; on an open frame munk_share is near 0",
        )


def straight_text(run: StraightRun) -> str:
    """Return such as `level, at 1.60 m/s, turned 3 deg to port and 0.8 m deeper`."""
    sides = "port" if run.heading_change_deg > 0 else "starboard"
    depth = "higher" if run.climb_m > 0 else "deeper"
    return (
        f"{attitude_text(run.nose_down_deg, run.roll_to_starboard_deg)}, at {run.speed_m_s:.2f} m/s, turned "
        f"{abs(run.heading_change_deg):.0f} deg to {sides} and {abs(run.climb_m):.1f} m {depth}"
    )


def attitude_text(nose_down_deg: float, roll_to_starboard_deg: float) -> str:
    """Return `level`, or `nose down 12.0 deg, listing 3.0 deg to port`."""
    parts = []
    if abs(nose_down_deg) >= 0.05:
        parts.append(f"nose {'down' if nose_down_deg > 0 else 'up'} {abs(nose_down_deg):.1f} deg")
    if abs(roll_to_starboard_deg) >= 0.05:
        side = "starboard" if roll_to_starboard_deg > 0 else "port"
        parts.append(f"listing {abs(roll_to_starboard_deg):.1f} deg to {side}")
    return ", ".join(parts) or "level"


def _of_inertia(figures: VehicleFigures) -> Iterator[Found]:
    low, high = GYRATION_SHARES
    for axis, inertia, own, solid, reach in zip(
        "xyz", figures.inertia_kg_m2, figures.gyration_m, figures.hull_gyration_m, figures.reach_m, strict=True
    ):
        share = (own / solid) ** 2
        times = f"{share:.3g} times" if share > 1.0 else f"1/{1.0 / share:.0f} of"
        what = f"its inertia about {axis}, {inertia:.3g} kg m2, is {times} that of a solid body of its size and mass: "
        what += f"its radius of gyration is {own:.3g} m"
        if own > reach:
            yield ("inertia_kg_m2",), f"{what}, but no point of its hull is farther than {reach:.3g} m from that axis"
        elif not low * solid <= own <= high * solid:
            yield ("inertia_kg_m2",), f"{what}, that of its hull as a solid {solid:.3g} m: is the inertia in kg m2?"


def _of_steering(figures: VehicleFigures) -> Iterator[Found]:
    drives = figures.drives
    if "surge" not in drives and not figures.glides:
        yield (), "neither thrusters nor forces drive it ahead"
    if "yaw" not in drives:
        yield (), "nothing turns it: neither thrusters nor fins give yaw"
    if figures.metacentric_m is not None:
        return
    if "heave" not in drives and "pitch" not in drives:
        yield (), "nothing takes it up or down: neither thrusters nor fins give heave or pitch"
    growth = figures.course_growth_1_s
    if growth is not None and growth > GROWTH_1_S:
        seconds = np.log(2.0) / growth
        what = f"it does not keep its course under way: a yaw doubles in {seconds:.1f} s"
        yield (), f"{what}; tail fins counter the Munk moment that turns it"


def _of_mount(mount: Mount, figures: VehicleFigures) -> Iterator[str]:
    what = mount.label
    if mount.away_m > AWAY_LENGTHS * max(figures.size_m):
        yield f"{what} is {mount.away_m:.3g} m away from its hull of {size_text(np.array(figures.size_m))}"
    elif mount.beams_in_hull >= BLOCKED_SHARE:
        share = "looks" if mount.beams_in_hull == 1.0 else f"looks with {100 * mount.beams_in_hull:.0f} % of its beams"
        yield f"{what} {share} into its own hull"
    if mount.off_down_deg is not None and mount.off_down_deg > OFF_DOWN_DEG:
        where = "up" if mount.off_down_deg > 90.0 else "sideways"
        yield f"{what} looks {where}, {mount.off_down_deg:.0f} deg off straight down: its beams need the bottom"


def _keys(mount: Mount) -> tuple[str | int, ...]:
    return (mount.key, mount.name) if mount.name else (mount.key,)
