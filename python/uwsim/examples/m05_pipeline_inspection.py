"""Pipeline inspection: the vehicle follows a pipeline by sonar and camera, either of which would suffice."""

import uwsim
from uwsim.missions import OwnVehicle, Steps
from uwsim.missions.planners.pipeline import PipelineTrack, follow_pipeline


def mission(vehicle: OwnVehicle, heading_rad: float = -0.3) -> Steps[PipelineTrack]:
    """Search for a pipe 0.8 m in diameter near one end, and follow it to the other end."""
    vehicle.undock()
    return (yield from follow_pipeline(vehicle, (-19.0, -5.0), heading_rad, diameter_m=0.8))


def main() -> None:
    """Fly the mission in the cove."""
    flown = uwsim.fly(mission, "cove")
    track = flown.result
    pictures = [event.values["contrast"] for event in flown.events if event.name == "picture"]
    print(
        f"{track.length_m:.0f} m of pipe in {flown.simulated_s:.0f} s, {len(pictures)} pictures; "
        f"seen {track.by_sonar} times by sonar, {track.by_camera} times by camera"
    )


if __name__ == "__main__":
    main()
