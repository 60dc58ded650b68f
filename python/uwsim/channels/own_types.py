"""Our own message types, as .msg definitions, for content that no existing package covers.

docs/connections/station-wire.md explains the fields.
"""

TELEMETRY = "uwsim_msgs/msg/Telemetry"
MAP_CHANGES = "uwsim_msgs/msg/MapChanges"
STATION_STATE = "uwsim_msgs/msg/StationState"
LINK = "uwsim_msgs/msg/Link"
SONAR_PING = "uwsim_msgs/msg/SonarPing"
PLACED_PING = "uwsim_msgs/msg/PlacedPing"

ALL_STOPPED = "all stop"
"""The alarm in the telemetry of a vehicle whose all stop is set."""

OWN_TYPES = {
    TELEMETRY: """\
std_msgs/Header header
float64[3] position            # m, in the odom frame: the vehicle's own estimate; nan without an IMU
float32[3] position_std        # m, along the frame's axes, as the estimate has it
float64[3] true_position       # m, in the odom frame; nan where the truth is not to be seen
float32[4] orientation         # x, y, z, w: the vehicle's own estimate
bool is_truth                  # whether the truth is to be seen
float32 speed                  # m/s
float32 angular_speed          # rad/s
float32 temperature            # deg C
float32 pressure               # Pa, absolute
float32 depth                  # m
float32 distance_to_station    # m
float32 distance_to_seabed     # m, straight down; inf: nothing
float32 distance_to_port       # m, of the proximity sensor; nan without one
float32 mission_time           # s since the release
float32 battery                # percent
float32 link_delay             # s, one way, of sound between vehicle and station
float32 tilt                   # rad, of the sonar's head; up is positive; nan without one
float32[] thrusters            # commands in [-1, 1], in their order
float32[] efforts              # surge, sway, heave, roll, pitch, yaw as commanded
bool[] lamps                   # in their order
bool released
bool range_warning
bool proximity_warning
bool collision_warning
uint32 collisions              # since the start
string failsafe                # what the vehicle does by itself: hold, surface, return, go_on; empty: nothing
string failsafe_cause          # silence, battery, leak, thruster, sensor
string[] alarms                # what it notices about itself; "all stop" while that is set
""",
    MAP_CHANGES: """\
std_msgs/Header header
uint32 sequence
bool snapshot                  # forget everything before this
float64 resolution             # m, edge of a voxel
int16[] blocks                 # 3 n: x, y, z of each block of 16 x 16 x 16 voxels, from the origin of header.frame_id
uint16[] counts                # n: how many cells follow for each
uint16[] cells                 # bits 0 to 3 x, 4 to 7 y, 8 to 11 z in the block; bit 15: occupied now, or no longer
""",
    LINK: """\
std_msgs/Header header         # docs/guides/link.md; of both directions together unless it says otherwise
string modem
float32 quality                # share of the packets so far that arrived
float32 delay                  # s, of the newest packet's first arrival; nan before that
float32 snr                    # dB, of that packet; nan over a cable and the ideal link
float32 closing_speed          # m/s, of the ends towards each other then: Doppler
float32 silence                # s since the vehicle heard the station
float32 silence_at_station     # s since the station heard the vehicle
uint32 queue_station           # bytes that wait
uint32 queue_vehicle
uint32 sent                    # messages
uint32 delivered
uint32 lost
uint32 late                    # not sent, since their time was over or the queue full
uint64 bytes_delivered         # of payloads
float32 fault_loss             # share of the packets that faults take now; 1: a blackout
""",
    PLACED_PING: """\
std_msgs/Header header         # a ping and its place: what a map is made from elsewhere; the pose is in this frame
geometry_msgs/Pose sonar       # beams lie in its x-y plane, angles from x to y
float32 angle_min              # rad
float32 angle_increment        # rad
float32[] ranges               # m, of each beam; inf: no echo, or one off the vehicle's own hull
""",
    SONAR_PING: """\
std_msgs/Header header         # in recordings alone: what maps are made from, to the last bit
float32[] ranges               # m, of each beam; inf: no echo
float32[] angles               # rad, positive to port
bool[] valid
int32[] labels                 # of what each beam met
float32[] intensities          # dB, the echo's level below that of the source; -inf: no echo
float64[16] frame_from_body    # rows of (4, 4), in header.frame_id
float64[16] frame_from_sonar
bool range_warning
bool proximity_warning
bool collision_warning
""",
    STATION_STATE: """\
string phase                   # idle, starting, running
uint32 session                 # changes with each simulator and each restart
uint32 edition                 # changes with parameters: what describes the simulator is to be asked for again
string scenario
string error                   # why the simulation stopped
float64 time                   # s, simulated
bool paused
float32 speed                  # simulated seconds per second that are wanted; 0: as many as possible
float32 factor                 # and achieved
float32 lateness               # s, worst delay of a step
string pilot                   # client who has the controls; empty: nobody
float32 pilot_silence          # s without anything from the pilot, answers to pings included; 0 below 1.5: all is well
string[] member_ids
string[] member_names
string[] asking                # members who want the controls
string recording               # file that is being written
""",
}
