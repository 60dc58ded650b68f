"""uwsim's own message types, for content that no existing package covers, as .msg definitions.

docs/reference/channels.md lists them.
"""

from uwsim.instruments.gauges import NUMBERS, VECTORS

TELEMETRY = "uwsim_msgs/msg/Telemetry"
SENSOR_GAUGES = "uwsim_msgs/msg/SensorGauges"
MAP_CHANGES = "uwsim_msgs/msg/MapChanges"
STATION_STATE = "uwsim_msgs/msg/StationState"
LINK = "uwsim_msgs/msg/Link"
FORCES = "uwsim_msgs/msg/Forces"
SONAR_PING = "uwsim_msgs/msg/SonarPing"
PLACED_PING = "uwsim_msgs/msg/PlacedPing"
HYDROPHONE_PING = "uwsim_msgs/msg/HydrophonePing"
NAMED_NUMBER = "uwsim_msgs/msg/NamedNumber"

ALL_STOPPED = "all stop"
"""The alarm in the telemetry of a vehicle whose all stop is set."""

OWN_TYPES = {
    TELEMETRY: """\
std_msgs/Header header
float64[3] position            # m, in the odom frame: the vehicle's own estimate; nan without an IMU
float32[3] position_std        # m, along the frame's axes, according to the estimate
float64[3] true_position       # m, in the odom frame; nan if the truth is hidden
float32[4] orientation         # x, y, z, w: the vehicle's own estimate
bool is_truth                  # whether the truth may be shown
"""
    + "".join(gauge.definition for gauge in NUMBERS)
    + """\
float32[] thrusters            # commands in [-1, 1], in the vehicle's order
float32[] efforts              # surge, sway, heave, roll, pitch, yaw as commanded
bool[] lamps                   # in the vehicle's order
bool released
bool range_warning
bool proximity_warning
bool collision_warning
uint32 collisions              # since the start
string failsafe                # active failsafe: hold, surface, return, go_on; empty: none
string failsafe_cause          # silence, battery, leak, thruster, sensor
string[] alarms                # failures detected aboard; "all stop" while that is set
"""
    + "".join(gauge.definition for gauge in VECTORS)
    + """\
string[] gauges                # fields above that are measured aboard, and nan if they cannot be; not over a modem
float32[] gauge_ages           # s since each was measured; inf: no valid measurement
string[] holds                 # active ones: heading, depth, altitude, position, speed
float32[] hold_targets         # of each: yaw [rad], depth [m], altitude [m], distance to the position [m], speed [m/s];
                               # nan while the stick moves the vehicle or it comes to rest
string hold_note               # why the last hold was lost or changed; empty: none was
""",
    SENSOR_GAUGES: """\
std_msgs/Header header
string[] names                 # "sensor NAME", followed by the quantity if the sensor has several
string[] units
float32[] values               # nan if they cannot be measured
float32[] ages                 # s since each was measured; inf: no valid measurement
""",
    MAP_CHANGES: """\
std_msgs/Header header
uint32 sequence
bool snapshot                  # true: discard all earlier messages
float64 resolution             # m, edge of a voxel
int16[] blocks                 # 3 n: x, y, z of each block of 16 x 16 x 16 voxels, from the origin of header.frame_id
uint16[] counts                # n: number of cells in each block
uint16[] cells                 # bits 0 to 3 x, 4 to 7 y, 8 to 11 z in the block; bit 15: 1 now occupied, 0 no longer
""",
    LINK: """\
std_msgs/Header header         # see docs/guides/link.md; values cover both directions unless stated otherwise
string modem
float32 quality                # fraction of all packets so far that arrived
float32 delay                  # s, of the newest packet, at its first arrival; nan before that
float32 snr                    # dB, of that packet; nan over a cable and the ideal link
float32 closing_speed          # m/s, at which the ends approached each other then (Doppler)
float32 silence                # s since the vehicle last received data from the station
float32 silence_at_station     # s since the station last received data from the vehicle
uint32 queue_station           # bytes waiting
uint32 queue_vehicle
uint32 sent                    # messages
uint32 delivered
uint32 lost
uint32 late                    # not sent, because they expired or the queue was full
uint64 bytes_delivered         # payload only
float32 fault_loss             # fraction of packets that faults currently destroy; 1: a blackout
""",
    FORCES: """\
std_msgs/Header header         # the body frame; true means over the last step, about its origin (docs/guides/forces.md)
string[] names                 # weight, buoyancy, drag, added_mass, coriolis, actuators, applied, contact, dock, total
geometry_msgs/Wrench[] wrenches # N and N m, of each
geometry_msgs/Point[] contact_points
geometry_msgs/Vector3[] contact_forces # N, on the vehicle, at each point
string[] contact_others        # what it touches there; empty: terrain or an obstacle
string[] contact_links         # the link of its arm at each point; empty: the vehicle itself
string[] contact_other_links   # likewise of what it touches
""",
    HYDROPHONE_PING: """\
std_msgs/Header header         # of the first sample, in the array's frame (docs/guides/pingers.md)
float64 rate                   # Hz, samples per second of each hydrophone
uint8 phones                   # number of hydrophones
float64 pascals_per_count      # pressure in the water for one count
int16[] samples                # those of all hydrophones at one time, then those at the next; clipped at full scale
""",
    PLACED_PING: """\
std_msgs/Header header         # a ping and its pose, for mapping elsewhere; the pose is in this frame
geometry_msgs/Pose sonar       # beams lie in its x-y plane, angles from x to y
float32 angle_min              # rad
float32 angle_increment        # rad
float32[] ranges               # m, of each beam; inf: no echo, or an echo from the vehicle's own hull
""",
    SONAR_PING: """\
std_msgs/Header header         # only in recordings: maps are rebuilt from it, to the last bit
float32[] ranges               # m, of each beam; inf: no echo
float32[] angles               # rad, positive to port
bool[] valid
int32[] labels                 # of the surface that each beam hit
float32[] intensities          # dB, the echo's level below that of the source; -inf: no echo
float64[16] frame_from_body    # rows of (4, 4), in header.frame_id
float64[16] frame_from_sonar
bool range_warning
bool proximity_warning
bool collision_warning
float32[] deviations           # m, standard deviation of each echo's place; empty: unknown, as in geometry mode
float32[] horizontal_deviations  # m, its horizontal part
""",
    NAMED_NUMBER: """\
string name                    # in requests of services: a thruster's or a fin's
float64 value
""",
    STATION_STATE: """\
string phase                   # idle, starting, running
uint32 session                 # changes with each simulator and each restart
uint32 edition                 # changes with parameters: call describe again
string scenario
string error                   # why the simulation stopped
float64 time                   # s, simulated
bool paused
float32 speed                  # requested simulated seconds per second; 0: as fast as possible
float32 factor                 # achieved simulated seconds per second
float32 lateness               # s, worst delay of a step
string pilot                   # id of the client in control; empty: none
float32 pilot_silence          # s since the last data from the pilot, including pongs; 0 below 1.5
string[] member_ids
string[] member_names
string[] asking                # ids of members who request control
string recording               # file being written; empty: none
string driver                  # kind of client, other than the pilot, whose command is in effect; empty: none
string lost_by                 # name of the pilot whose connection was lost, until control is taken; empty: none
string rosbridge               # address of the user's rosbridge that the simulator has joined; empty: none
string rosbridge_trouble       # why it is not connected to it; empty: it is
string rosbridge_refusals      # what it refuses of our topics and services, and why; empty: nothing
string comment                 # stands in pictures; empty: none
uint32 notes                   # written so far in this run, comments included
string flight                  # automatic recording of this flight; empty: none
string flight_trouble          # why the flight is not recorded, or no further; empty: it is, or none are kept
""",
}
