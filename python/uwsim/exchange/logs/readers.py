"""The logs of real flights that are known by their content, in the group `uwsim.kinds.flight_log` of entry points."""

from uwsim.base.reader import Reader
from uwsim.exchange.logs import autopilot, glider_log, odometry_bag, telemetry_log

DATAFLASH = Reader(autopilot.KIND, lambda path, head: head.startswith(autopilot.MAGIC), autopilot.read_dataflash)
BAG = Reader(odometry_bag.KIND, odometry_bag.is_bag, odometry_bag.read_bag)
GLIDER = Reader(glider_log.KIND, lambda path, head: head.startswith(glider_log.MAGIC), glider_log.read_glider)
TELEMETRY = Reader(telemetry_log.KIND, telemetry_log.is_telemetry, telemetry_log.read_telemetry)
