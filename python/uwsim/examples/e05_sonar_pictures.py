"""Three imaging sonars in the lake: a picture ahead, a side-scan waterfall, and a profile of the pipeline."""

import numpy as np

from uwsim import Simulator
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import ForwardLooking, SideScan, SingleBeam


def main() -> None:
    """Image the gate, pass it with a side-scan sonar, and measure the pipeline's cross-section."""
    sim = Simulator("lake", seed=7)

    # A pose is world_from_sonar: x ahead, positive pitch nose down.
    ahead = imaging.pose_matrix((-75.0, -57.0, -24.0), yaw_rad=0.14, pitch_rad=0.2)
    image = imaging.look_ahead(sim, ahead, ForwardLooking(range_max_m=30.0, range_bins=750))
    row, column = np.unravel_index(np.argmax(image.level_db - image.noise_db[:, None]), image.level_db.shape)
    bearing_deg = np.degrees(image.bearings_rad[column])
    print(f"picture {image.level_db.shape}: brightest at {image.ranges_m[row]:.1f} m, {bearing_deg:+.1f} deg")

    track = [imaging.pose_matrix((x, -57.0, -24.0)) for x in np.arange(-75.0, -45.0, 0.5)]
    waterfall = imaging.look_aside(sim, track, SideScan(strengths_db={"pipeline_main": -10.0}))
    lowest, highest = waterfall.altitude_m.min(), waterfall.altitude_m.max()
    print(f"waterfall {waterfall.picture_db().shape}: {lowest:.1f} to {highest:.1f} m above the bottom")

    down = imaging.pose_matrix((-60.0, -22.0, -24.0), yaw_rad=1.4, pitch_rad=np.pi / 2)
    profile = imaging.profile(sim, down, np.radians(np.arange(-60.0, 60.1, 0.9)), SingleBeam())
    section_m = profile.points_world_m
    print(
        f"profile of {len(section_m)} pings: highest point {np.nanmax(section_m[:, 2]):.2f} m, the top of the pipeline"
    )


if __name__ == "__main__":
    main()
