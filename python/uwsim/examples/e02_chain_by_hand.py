"""The processing chain from pings to an OctoMap, one step per line: text, ranges, LaserScan, cloud, world, map."""

import tempfile
from pathlib import Path

import uwsim
from uwsim.mapping import OccupancyMap, ranging


def main() -> None:
    """Ping in the pool at eight headings and write the map."""
    sim = uwsim.Simulator("pool", sonar_model=2)
    rov = sim.rov
    rov.release()
    rov.sonar.aim(elevation_rad=-0.4)
    occupancy = OccupancyMap(resolution_m=0.2)
    for _ in range(8):
        rov.set_effort(yaw=0.5)
        sim.advance(1.5)
        ping = rov.sonar.ping()
        text = ranging.encode_depth_string(ping.ranges_m, model=2)  # "5.33a5.31a..." as on the wire
        ranges_m = ranging.decode_depth_string(text, model=2)
        scan = ranging.to_laser_scan(ranges_m, model=2, stamp_s=sim.time_s)
        points_sonar_m = ranging.to_point_cloud(scan)
        points_world_m = ranging.transform_points(points_sonar_m, ping.world_from_sonar)
        occupancy.insert_scan(points_world_m, ping.world_from_sonar[:3, 3], max_range_m=55.0)
    path = Path(tempfile.gettempdir()) / "pool.bt"
    occupancy.write(path)
    print(f"{occupancy.statistics().occupied_voxels} occupied voxels in {path}")


if __name__ == "__main__":
    main()
