"""Write docs/guides/vehicle.png, the three views in the report of `uwsim vehicle rov --out FILE`."""

from pathlib import Path

from PIL import Image

from uwsim.evidence.scenario_check import check_part
from uwsim.evidence.vehicle.page import draw_hull
from uwsim.evidence.vehicle.report import vehicle_report

PICTURE = Path(__file__).parents[2] / "docs" / "guides" / "vehicle.png"

check = check_part("rov", "vehicle")
assert check.simulator is not None and check.vehicle is not None
draw_hull(PICTURE, vehicle_report(check.simulator, check.vehicle))
Image.open(PICTURE).quantize(128).save(PICTURE, optimize=True)
