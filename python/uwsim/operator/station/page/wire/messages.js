// Made by `python -m uwsim.operator.station.wire_js` from commands, messages and calls.py: do not edit.

/** @typedef {{ stamp: { sec: number, nanosec: number }, frame_id: string }} Header */
/** @typedef {ArrayLike<number> & Iterable<number>} Numbers */
/** @typedef {{ call(service: string, args?: object): Promise<any> }} Caller */

export const AXES = ['surge', 'sway', 'heave', 'roll', 'pitch', 'yaw'];
// The alarm in the telemetry of a vehicle whose all stop is set.
export const ALL_STOPPED = 'all stop';
// The silence of a pilot after which others may take the controls.
export const FREE_S = 3.0;
// The bounds of a plan's speed.
export const PLAN_SPEEDS_M_S = [0.05, 3.0];
// The cells along an axis of the map's blocks.
export const BLOCK_EDGE = 16;
// The kinds of views from imaging sonars.
export const SONAR_KINDS = ['forward_looking', 'side_scan', 'single_beam'];
// Those of sonar pictures, from the weakest to the strongest level.
export const SONAR_COLOURS = ['#000000', '#4a2503', '#c47a1a', '#ffd98a', '#fffbe8'];
// Between the first and the last of them.
export const SONAR_SPAN_DB = 25.0;
export const NOTE_CATEGORIES = ['observation', 'defect', 'leak', 'debris', 'growth'];
// The fields of the telemetry that are gauges, in the order of the panel.
export const GAUGES = [
  { name: 'speed', unit: 'm/s', list: 'motion', column: 'speed_m_s' },
  { name: 'angular_speed', unit: 'rad/s', list: 'motion', column: 'angular_speed_rad_s' },
  { name: 'linear_acceleration', word: 'acceleration', unit: 'm/s2', list: 'motion', column: 'acceleration_%_m_s2' },
  { name: 'angular_acceleration', unit: 'rad/s2', list: 'motion', column: 'angular_acceleration_%_rad_s2' },
  { name: 'depth', unit: 'm', list: 'big', column: 'depth_m' },
  { name: 'distance_to_seabed', word: 'altitude', unit: 'm', list: 'big', column: 'altitude_m' },
  { name: 'distance_to_station', word: 'to_station', unit: 'm', list: 'around', column: 'to_station_m' },
  { name: 'distance_to_port', word: 'to_port', unit: 'm', list: 'around', column: 'to_port_m' },
  { name: 'temperature', unit: 'deg C', list: 'water', column: 'temperature_deg_c' },
  { name: 'pressure', unit: 'Pa', list: 'water', column: 'pressure_pa' },
  { name: 'link_delay', unit: 's', list: 'water', column: 'link_delay_s' },
  { name: 'mission_time', unit: 's', list: '', column: 'mission_time_s' },
  { name: 'battery', unit: 'percent', list: '', column: 'battery_percent' },
  { name: 'tilt', unit: 'rad', list: '', column: 'tilt_rad' },
];
// The arguments of the command `hold`.
export const HOLDS = ['heading', 'depth', 'altitude', 'position', 'speed'];
// The types of topics, by their last name.
export const TYPES = {
  StationState: 'uwsim_msgs/StationState',
  Telemetry: 'uwsim_msgs/Telemetry',
  SensorGauges: 'uwsim_msgs/SensorGauges',
  MapChanges: 'uwsim_msgs/MapChanges',
  Link: 'uwsim_msgs/Link',
};
// The arguments of each command that the pilot may give by name.
export const COMMANDS = {
  release: [],
  undock: [],
  dock: [],
  override_failsafe: [],
  inject_fault: ['kind'],
  end_fault: ['name'],
  hold: ['heading', 'depth', 'altitude', 'position', 'speed'],
  hold_at: ['heading_rad', 'z_world_m'],
  set_winch: ['rate_m_s', 'tension_n'],
  set_joints: ['positions', 'speeds', 'torques'],
  drop: ['dropper'],
  start_navigation: ['use'],
  aim: ['elevation_rad', 'sonar'],
  set_lamp: ['lamp', 'on'],
  aim_camera: ['camera', 'pan_rad', 'tilt_rad'],
  set_optics: [],
  set_parameter: ['name', 'value'],
  set_parameters: ['changes'],
  reset_parameters: ['name'],
};
// Those that are services of a vehicle, too.
export const SERVICES = ['release', 'undock', 'dock', 'override_failsafe', 'hold'];

/** @typedef {object} StationState
 * @property {string} phase
 * @property {number} session
 * @property {number} edition
 * @property {string} scenario
 * @property {string} error
 * @property {number} time
 * @property {boolean} paused
 * @property {number} speed
 * @property {number} factor
 * @property {number} lateness
 * @property {string} pilot
 * @property {number} pilot_silence
 * @property {string[]} member_ids
 * @property {string[]} member_names
 * @property {string[]} asking
 * @property {string} recording
 * @property {string} driver
 * @property {string} lost_by
 * @property {string} rosbridge
 * @property {string} rosbridge_trouble
 * @property {string} rosbridge_refusals
 * @property {string} comment
 * @property {number} notes
 * @property {string} flight
 * @property {string} flight_trouble
 * @property {string} instruction
 */

/** @typedef {object} Telemetry
 * @property {Header} header
 * @property {Numbers} position
 * @property {Numbers} position_std
 * @property {Numbers} true_position
 * @property {Numbers} orientation
 * @property {boolean} is_truth
 * @property {number} speed
 * @property {number} angular_speed
 * @property {number} temperature
 * @property {number} pressure
 * @property {number} depth
 * @property {number} distance_to_station
 * @property {number} distance_to_seabed
 * @property {number} distance_to_port
 * @property {number} mission_time
 * @property {number} battery
 * @property {number} link_delay
 * @property {number} tilt
 * @property {Numbers} thrusters
 * @property {Numbers} efforts
 * @property {boolean[]} lamps
 * @property {boolean} released
 * @property {boolean} range_warning
 * @property {boolean} proximity_warning
 * @property {boolean} collision_warning
 * @property {number} collisions
 * @property {string} failsafe
 * @property {string} failsafe_cause
 * @property {string[]} alarms
 * @property {Numbers} linear_acceleration
 * @property {Numbers} angular_acceleration
 * @property {string[]} gauges
 * @property {Numbers} gauge_ages
 * @property {string[]} holds
 * @property {Numbers} hold_targets
 * @property {string} hold_note
 */

/** @typedef {object} SensorGauges
 * @property {Header} header
 * @property {string[]} names
 * @property {string[]} units
 * @property {Numbers} values
 * @property {Numbers} ages
 */

/** @typedef {object} MapChanges
 * @property {Header} header
 * @property {number} sequence
 * @property {boolean} snapshot
 * @property {number} resolution
 * @property {Numbers} blocks
 * @property {Numbers} counts
 * @property {Numbers} cells
 */

/** @typedef {object} Link
 * @property {Header} header
 * @property {string} modem
 * @property {number} quality
 * @property {number} delay
 * @property {number} snr
 * @property {number} closing_speed
 * @property {number} silence
 * @property {number} silence_at_station
 * @property {number} queue_station
 * @property {number} queue_vehicle
 * @property {number} sent
 * @property {number} delivered
 * @property {number} lost
 * @property {number} late
 * @property {number} bytes_delivered
 * @property {number} fault_loss
 */

/** The panel's warning distances. as_published: whether its lamps are the published simulator's.
 * @typedef {object} Warnings
 * @property {number} range_m
 * @property {number} proximity_m
 * @property {boolean} as_published
 */

/** A sensor that looks in one direction, and the topic of its ranges.
 * @typedef {object} Proximity
 * @property {string} name
 * @property {string} topic
 */

/** The range and rate of a sonar head's tilt.
 * @typedef {object} Tilt
 * @property {number} min_rad
 * @property {number} max_rad
 * @property {number} rate_rad_s
 */

/** A multibeam sonar.
 * @typedef {object} Multibeam
 * @property {string} name
 * @property {string} title
 * @property {number} range_m
 * @property {number} beams
 * @property {number} fov_rad
 */

/** A camera with a pan-tilt motor, and its limits.
 * @typedef {object} Motor
 * @property {string} camera
 * @property {number[]} pan_deg
 * @property {number[]} tilt_deg
 */

/** A tether of a vehicle or loose body. turns: null without upright obstacles. fastest_m_s: null without a winch.
 * @typedef {object} TetherDescription
 * @property {string} shape
 * @property {string} tension
 * @property {string | null} turns
 * @property {number[]} origin_m
 * @property {number} breaking_load_n
 * @property {number | null} fastest_m_s
 * @property {number | null} strongest_n
 */

/** A joint of an arm with a motor, and its stops [rad or m]; the page's own where it has none. is_jaw: whether it is one of a gripper's.
 * @typedef {object} ArmJoint
 * @property {string} name
 * @property {number} low
 * @property {number} high
 * @property {boolean} is_slide
 * @property {boolean} is_jaw
 */

/** A vehicle: its topics, null where there is none, and its parts.
 * @typedef {object} VehicleDescription
 * @property {string} name
 * @property {string} model
 * @property {string} prefix
 * @property {string | null} telemetry
 * @property {string | null} sensor_gauges
 * @property {string | null} scan
 * @property {string | null} joints
 * @property {Proximity[]} proximities
 * @property {string | null} link
 * @property {string | null} map
 * @property {string | null} map_changes
 * @property {number} pings_per_s
 * @property {string[]} thrusters
 * @property {string[]} lamps
 * @property {string[]} droppers
 * @property {string[]} efforts
 * @property {string[]} holds
 * @property {Tilt | null} tilt
 * @property {Multibeam | null} sonar
 * @property {Motor[]} motors
 * @property {TetherDescription | null} tether
 * @property {ArmJoint[]} arm
 * @property {boolean} can_jog
 */

/** A camera's mount and lens. follows: `body`, or `heading` from outside. turns: whether it has a motor.
 * @typedef {object} Optics
 * @property {number[]} yaw_pitch_roll_deg
 * @property {number} horizontal_fov_deg
 * @property {'body' | 'heading'} follows
 * @property {boolean} turns
 */

/** The layout of a sonar picture. shape: `fan`, apex below; `fan_down`, apex above; `waterfall`, newest first. fov_rad: the fan's angle; 0 for a waterfall.
 * @typedef {object} SonarPicture
 * @property {'fan' | 'fan_down' | 'waterfall'} shape
 * @property {number} range_m
 * @property {number} fov_rad
 */

/** The transmission of pictures over a link. period_s: null if there is no capacity for pictures.
 * @typedef {object} ViewLink
 * @property {string} modem
 * @property {number | null} period_s
 * @property {boolean} large_only
 */

/** A view, with the size of its pictures, 0 if that varies. kind: `camera`, `station`, `chase` or a sonar's.
 * @typedef {object} ViewDescription
 * @property {string} name
 * @property {string} title
 * @property {string} kind
 * @property {string} vehicle
 * @property {string} frame_id
 * @property {number} width
 * @property {number} height
 * @property {string} topic
 * @property {string} small_topic
 * @property {Optics | null} [optics]
 * @property {SonarPicture | null} [sonar]
 * @property {ViewLink | null} [link]
 * @property {string | null} [aboard_topic]
 * @property {string | null} [aboard_small_topic]
 */

/** A school of fish or a plume of bubbles. drawn: how many of it are drawn. colour: albedo, red, green and blue.
 * @typedef {object} SwarmDescription
 * @property {string} name
 * @property {'fish' | 'bubbles'} kind
 * @property {number} drawn
 * @property {number} size_m
 * @property {number[]} colour
 */

/** The topic with the places of all swarms, one after the other, and the swarms.
 * @typedef {object} LifeDescription
 * @property {string} topic
 * @property {SwarmDescription[]} swarms
 */

/** A value of an event in English words, with its unit.
 * @typedef {object} EventDetail
 * @property {string} name
 * @property {string} text
 */

/** An event of a recorded flight. name: of the command or the event. text: all of it in English.
 * @typedef {object} FlightEvent
 * @property {number} time_s
 * @property {'command' | 'alarm' | 'collision'} kind
 * @property {string} text
 * @property {string} name
 * @property {string} vehicle
 * @property {EventDetail[]} details
 */

/** The flight being replayed. start_s, end_s: the ends of its time line, in simulated time.
 * @typedef {object} ReplayDescription
 * @property {string} flight
 * @property {number} start_s
 * @property {number} end_s
 * @property {string} branched_from
 * @property {FlightEvent[]} events
 */

/** The running simulator. tethers: those of loose bodies, by name.
 * @typedef {object} Description
 * @property {true} success
 * @property {number} session
 * @property {number} edition
 * @property {boolean} is_fixed
 * @property {string[]} controls
 * @property {string} scenario
 * @property {string} description
 * @property {number} step_s
 * @property {number} mission_time_s
 * @property {number} seed
 * @property {boolean} truth_allowed
 * @property {Warnings} warnings
 * @property {VehicleDescription[]} vehicles
 * @property {ViewDescription[]} views
 * @property {string} scene
 * @property {Record<string, TetherDescription>} tethers
 * @property {string | null} objects
 * @property {LifeDescription | null} life
 * @property {string[]} commands
 * @property {boolean} has_exercise
 * @property {boolean} has_survey
 * @property {boolean} is_supervised
 * @property {boolean} is_recorded
 * @property {ReplayDescription | null} replay
 * @property {string} branched_from
 */

/** A request to join the members. name: shown to the other members.
 * @typedef {object} Join
 * @property {string | null} [name]
 */

/** The response to a Join. id: identifies this connection.
 * @typedef {object} Joined
 * @property {true} success
 * @property {string} message
 * @property {string} id
 */

/** The response of a service that succeeded.
 * @typedef {object} Done
 * @property {true} success
 * @property {string} message
 */

/** A request to hand over the controls. to: the id of another member; empty releases the controls.
 * @typedef {object} HandOver
 * @property {string | null} [to]
 */

/** Efforts in [-1, 1], by default 0. stamp_ms: the time on the page's clock at which the keys were read.
 * @typedef {object} Drive
 * @property {string} vehicle
 * @property {number | null} [surge]
 * @property {number | null} [sway]
 * @property {number | null} [heave]
 * @property {number | null} [roll]
 * @property {number | null} [pitch]
 * @property {number | null} [yaw]
 * @property {number | null} [stamp_ms]
 */

/** The response to a Drive. age_s: the delay of the command.
 * @typedef {object} Driven
 * @property {true} success
 * @property {string} message
 * @property {number} tick
 * @property {number} age_s
 */

/** Shares in [-1, 1] with which an arm moves. joints: of their fastest speeds, by name. hand: of 0.1 m/s, ahead, to the left and up in the picture of a camera of the vehicle, by default along its own axes. grip: closes the jaws, or opens them. stamp_ms: as of Drive.
 * @typedef {object} MoveArm
 * @property {string} vehicle
 * @property {Record<string, number> | null} [joints]
 * @property {number[] | null} [hand]
 * @property {string | null} [camera]
 * @property {number | null} [grip]
 * @property {number | null} [stamp_ms]
 */

/** A request to set or release all stop. on: false releases it.
 * @typedef {object} AllStop
 * @property {string} vehicle
 * @property {boolean | null} [on]
 */

/** A command has taken effect at a tick, or has been sent over a link.
 * @typedef {object} Commanded
 * @property {true} success
 * @property {string} message
 * @property {number} tick
 */

/** A request to issue a command. name: one of the commands listed in the description. args: its arguments.
 * @typedef {object} Order
 * @property {string} name
 * @property {string | null} [vehicle]
 * @property {Record<string, any> | null} [args]
 */

/** An aid that the exercise allows, or that was used, and the points that it cost.
 * @typedef {object} AidState
 * @property {'autopilot' | 'hold' | 'program'} kind
 * @property {boolean} is_allowed
 * @property {number} used_s
 * @property {number} cost_per_s
 * @property {number} cost
 */

/** A goal of an exercise. share: the fraction achieved, 0 to 1.
 * @typedef {object} GoalState
 * @property {string} title
 * @property {number} points
 * @property {number} share
 */

/** A broken limit of an exercise, and the points that it cost. title: the limit in English.
 * @typedef {object} BrokenLimit
 * @property {string} title
 * @property {string} kind
 * @property {number} cost
 * @property {number} time_s
 */

/** The state of an exercise. points: the maximum; lost: deducted; has_sheet: whether an attempt's sheet exists. has_begun: false until the pilot begins the attempt. invalid_because: why the score is not valid, or "". name: of a packaged exercise, or "". next_name, next_title: of the one that the pilot may start after it, or "". flight: the recording of the attempt that has ended, from its begin, or "".
 * @typedef {object} ExerciseState
 * @property {true} success
 * @property {string} name
 * @property {string} title
 * @property {string} next_name
 * @property {string} next_title
 * @property {string} brief
 * @property {number} time_s
 * @property {number} limit_s
 * @property {number} score
 * @property {number} points
 * @property {number} pass_points
 * @property {number} lost
 * @property {number} attempt
 * @property {boolean} has_begun
 * @property {boolean} is_valid
 * @property {string} invalid_because
 * @property {AidState[]} aids
 * @property {boolean} is_over
 * @property {boolean} has_passed
 * @property {string} ended_because
 * @property {GoalState[]} goals
 * @property {BrokenLimit[]} broken
 * @property {boolean} has_sheet
 * @property {string} flight
 * @property {string} error
 */

/** A request to become the instructor.
 * @typedef {object} Supervise
 * @property {string} token
 */

/** A request by the instructor. action, args: see docs/connections/station-wire.md.
 * @typedef {object} Instruct
 * @property {string} action
 * @property {Record<string, any> | null} [args]
 */

/** A vehicle's true state. is_stopped: whether all stop is set, paused or not.
 * @typedef {object} VehicleTruth
 * @property {string} name
 * @property {number[]} position_world_m
 * @property {number} heading_deg
 * @property {number} speed_m_s
 * @property {number | null} altitude_m
 * @property {number} battery_percent
 * @property {number} collisions
 * @property {boolean} is_stopped
 * @property {string[]} sensors
 * @property {string[]} thrusters
 * @property {string[]} cameras
 */

/** When a fault began or begins. end_s: when it ended, or null. planned_end_s: when it is to end, null for never.
 * @typedef {object} FaultTime
 * @property {string} name
 * @property {string} kind
 * @property {string} size
 * @property {number} begin_s
 * @property {number | null} end_s
 * @property {number | null} planned_end_s
 */

/** A moment to return to.
 * @typedef {object} SavedMoment
 * @property {string} name
 * @property {number} time_s
 */

/** An entry of the log of both sides. clock: wall-clock time, ISO 8601. by: "instructor", or the pilot's name.
 * @typedef {object} Instruction
 * @property {number} time_s
 * @property {string} clock
 * @property {string} by
 * @property {string} action
 * @property {Record<string, any>} args
 * @property {string} text
 * @property {EventDetail[]} details
 */

/** The truth, for the instructor. exercise: an ExerciseState without `success`. log: newest first.
 * @typedef {object} Overview
 * @property {true} success
 * @property {number} time_s
 * @property {VehicleTruth[]} vehicles
 * @property {string[]} faults
 * @property {FaultTime[]} fault_times
 * @property {Record<string, any> | null} exercise
 * @property {SavedMoment[]} moments
 * @property {Instruction[]} log
 */

/** A key of a kind of fault. part: the list in VehicleTruth of which it names an item, or "". width: the number of values. low, high: their bounds, or null. choices: the permitted values, or none for any. value: the one with which a form begins.
 * @typedef {object} FaultField
 * @property {string} name
 * @property {string} meaning
 * @property {boolean} is_number
 * @property {boolean} is_optional
 * @property {number} width
 * @property {string} unit
 * @property {number | null} low
 * @property {number | null} high
 * @property {any[]} choices
 * @property {string} part
 * @property {any} value
 */

/** A kind of fault that the instructor may inject, and its keys.
 * @typedef {object} FaultKind
 * @property {string} kind
 * @property {string} meaning
 * @property {FaultField[]} fields
 */

/** All kinds of faults, those of other packages last.
 * @typedef {object} FaultKinds
 * @property {true} success
 * @property {FaultKind[]} kinds
 */

/** All parameters. descriptions_json: as returned by /simulation/describe_parameters. visibility_m: how far one sees horizontally in each type of water.
 * @typedef {object} ParameterList
 * @property {true} success
 * @property {string} descriptions_json
 * @property {Record<string, number>} visibility_m
 */

/** A request about a plan. action: report, lanes, save, fly or stop. points_m: x, y, z in odom. name: the file's.
 * @typedef {object} PlanRequest
 * @property {string} action
 * @property {string | null} [vehicle]
 * @property {number[][] | null} [points_m]
 * @property {number | null} [speed_m_s]
 * @property {string | null} [name]
 */

/** The state of the plan. reached: the number of the last waypoint reached. points_m, speed_m_s: of the scenario's survey, in the answer about its lanes.
 * @typedef {object} PlanState
 * @property {true} success
 * @property {string} message
 * @property {boolean} is_flying
 * @property {number} reached
 * @property {string} ended_because
 * @property {number[][] | null} [points_m]
 * @property {number | null} [speed_m_s]
 */

/** A request about notes. action: list, add or comment. view: a camera's, to add a picture. place: view or vehicle.
 * @typedef {object} NotesRequest
 * @property {string} action
 * @property {string | null} [vehicle]
 * @property {string | null} [text]
 * @property {string | null} [category]
 * @property {string | null} [place]
 * @property {string | null} [view]
 */

/** A note. position_m: in odom, null if unknown. picture: file name, or "".
 * @typedef {object} NoteState
 * @property {number} number
 * @property {number} time_s
 * @property {string} vehicle
 * @property {string} category
 * @property {string} text
 * @property {number[] | null} position_m
 * @property {string} picture
 */

/** The notes of the run so far, and the comment shown in pictures.
 * @typedef {object} NotesState
 * @property {true} success
 * @property {string} message
 * @property {string} comment
 * @property {NoteState[]} notes
 */

/** A request to change a view's pictures. width: 0 for the camera's own width.
 * @typedef {object} SetView
 * @property {string} name
 * @property {number | null} [rate_hz]
 * @property {number | null} [width]
 * @property {number | null} [quality]
 */

/** A vehicle of an offered scenario.
 * @typedef {object} OfferedVehicle
 * @property {string} name
 * @property {string} model
 */

/** A scenario that can be chosen.
 * @typedef {object} OfferedScenario
 * @property {string} name
 * @property {string} description
 * @property {'own' | 'lakes' | 'sea' | 'structures' | 'basins'} group
 * @property {boolean} has_survey
 * @property {number} seed
 * @property {number} mission_time_s
 * @property {OfferedVehicle[]} vehicles
 * @property {string | null} sonar
 * @property {number | null} tilt_deg
 */

/** An item that can be chosen by name.
 * @typedef {object} Offered
 * @property {string} name
 * @property {string} description
 */

/** A multibeam that can be chosen. A number refers to one of the paper's models.
 * @typedef {object} OfferedSonar
 * @property {number | string} name
 * @property {string} title
 * @property {string} description
 * @property {'published' | 'instrument'} kind
 */

/** A packaged exercise. best: the best valid score in the log book, or null.
 * @typedef {object} OfferedExercise
 * @property {string} name
 * @property {string} title
 * @property {string} brief
 * @property {string} scenario
 * @property {number} time_s
 * @property {number} points
 * @property {number} pass_points
 * @property {number | null} best
 */

/** The choice on the start screen. A missing or null field keeps the scenario's value. tilt_deg: of the sonar's head, down. rosbridge_*: the user's server.
 * @typedef {object} Choice
 * @property {string | null} [scenario]
 * @property {string | null} [vehicle]
 * @property {number | string | null} [sonar]
 * @property {number | null} [tilt_deg]
 * @property {number | null} [mission_time_s]
 * @property {number | null} [seed]
 * @property {number | null} [speed]
 * @property {string | null} [link]
 * @property {string | null} [rosbridge_host]
 * @property {number | null} [rosbridge_port]
 * @property {number | null} [rosbridge_ros]
 * @property {string | null} [saved]
 * @property {string | null} [flight]
 * @property {string | null} [exercise_name]
 */

/** A recorded flight. begun: wall-clock time, ISO 8601. refused: why the flight cannot be replayed, or empty. from_log: the file of a real flight from which it was made, or empty. cut_off: whether its recording ends early, after duration_s, because the station was killed or the disk was full.
 * @typedef {object} RecordedFlight
 * @property {string} exercise
 * @property {'' | 'offered' | 'making' | 'made'} film
 * @property {number} film_share
 * @property {string} film_trouble
 * @property {string} name
 * @property {string} scenario
 * @property {string} begun
 * @property {number} duration_s
 * @property {boolean} cut_off
 * @property {number} size_bytes
 * @property {string} branched_from
 * @property {string} from_log
 * @property {string} refused
 */

/** All available choices. speeds: 0 is as fast as possible. saves: sessions that can be continued. flights: newest first. exercises: in the order of the course.
 * @typedef {object} Catalog
 * @property {OfferedScenario[]} scenarios
 * @property {Offered[]} vehicles
 * @property {OfferedSonar[]} sonars
 * @property {OfferedExercise[]} exercises
 * @property {number[]} tilts_deg
 * @property {Offered[]} links
 * @property {number[]} speeds
 * @property {Choice} defaults
 * @property {string[]} saves
 * @property {RecordedFlight[]} flights
 */

/** The response to a choice that is valid or has been started.
 * @typedef {object} ChoiceTaken
 * @property {true} success
 * @property {string} message
 * @property {Record<string, string>} errors
 */

/** A field of a kind of part. type: number (width: how many), flag, choice, text, table (columns) or yaml. low, high: bounds in unit, or null. by_default: its value if it is left out; of a table, one for each column. role: place, turn or line for what the chart moves, mesh for a mesh's file, or "".
 * @typedef {object} FormField
 * @property {string} name
 * @property {string} meaning
 * @property {'number' | 'flag' | 'choice' | 'text' | 'table' | 'yaml'} type
 * @property {string} unit
 * @property {number | null} low
 * @property {number | null} high
 * @property {number} width
 * @property {string[]} columns
 * @property {any[]} choices
 * @property {any} by_default
 * @property {boolean} is_required
 * @property {'' | 'place' | 'turn' | 'line' | 'mesh'} role
 */

/** A kind of part, "" if its section has no kinds, and its fields.
 * @typedef {object} FormKind
 * @property {string} kind
 * @property {FormField[]} fields
 */

/** A section of a scenario. holds: list, names or one. of_vehicle: whether each vehicle has it.
 * @typedef {object} FormSection
 * @property {string} name
 * @property {'list' | 'names' | 'one'} holds
 * @property {boolean} of_vehicle
 * @property {FormKind[]} kinds
 */

/** The sections of a scenario that can be edited, with their kinds and fields, from its schema.
 * @typedef {object} EditForms
 * @property {true} success
 * @property {FormSection[]} sections
 */

/** A request to the editor. action: new, open, report, set, add, move, remove, undo, redo, revert, check, save, meshes, upload, apply or close. scenario: the one to open, by default the running one. section, place: of a part. kind, vehicle, at_m: of one to add. values: fields to set, also of one to add; null removes one. name: under which it is saved, or of a mesh to upload. to: the number of the goal with which one changes places. size, at, data: bytes of the whole mesh, and a part of it in Base64.
 * @typedef {object} Edit
 * @property {string} action
 * @property {string | null} [scenario]
 * @property {string | null} [section]
 * @property {any[] | null} [place]
 * @property {string | null} [kind]
 * @property {number | null} [vehicle]
 * @property {number[] | null} [at_m]
 * @property {Record<string, any> | null} [values]
 * @property {string | null} [name]
 * @property {number | null} [to]
 * @property {number | null} [size]
 * @property {number | null} [at]
 * @property {string | null} [data]
 */

/** The grid of heights in FILES/terrain.f32, in the world. edition: changes with the heights.
 * @typedef {object} BedGrid
 * @property {number} rows
 * @property {number} columns
 * @property {number} west_m
 * @property {number} south_m
 * @property {number[]} spacing_m
 * @property {number} edition
 */

/** A part of the edited scene. vehicle: the number of the vehicle that carries it. place: its keys in the file, after "exercise" for the exercise's. is_inherited: whether it comes from the vehicle's own file, or is a start at the station. frame: x, y [m], yaw [deg] and z [m] in the world of the axes of its position. values: as written, tables as rows of numbers. outline_m: of an obstacle. choices: names of the scene that a field can have, by field.
 * @typedef {object} EditedPart
 * @property {string} section
 * @property {any[]} place
 * @property {string} name
 * @property {string} kind
 * @property {number | null} vehicle
 * @property {boolean} is_inherited
 * @property {number[]} frame
 * @property {Record<string, any>} values
 * @property {number[][]} outline_m
 * @property {Record<string, string[]>} choices
 */

/** The editor's state; without a scenario, only is_open, false. by: the name of the client that edits. edition: changes with the text. files: the secret address FILES of what belongs to the scene. plan: changes with the obstacles, whose solids are FILES/PLAN/NUMBER.glb. added: the place of what was added or moved, or empty. mistakes: found by `check`. meshes: the files of which solids can be made, with a still at FILES/mesh/FILE.png. mesh: the file of a finished upload, "" before; lost: what of it was not taken along.
 * @typedef {object} EditState
 * @property {true} success
 * @property {string} message
 * @property {boolean} is_open
 * @property {string} by
 * @property {string | null} [name]
 * @property {number | null} [edition]
 * @property {boolean | null} [can_undo]
 * @property {boolean | null} [can_redo]
 * @property {boolean | null} [is_saved]
 * @property {boolean | null} [is_of_running]
 * @property {BedGrid | null} [grid]
 * @property {number | null} [plan]
 * @property {string[] | null} [vehicles]
 * @property {EditedPart[] | null} [parts]
 * @property {string | null} [text]
 * @property {any[] | null} [added]
 * @property {string[] | null} [mistakes]
 * @property {string | null} [files]
 * @property {string[] | null} [meshes]
 * @property {string | null} [mesh]
 * @property {string | null} [lost]
 */

/** A request about the debriefing film of a flight. language: begin to make it in that language.
 * @typedef {object} FilmRequest
 * @property {string} flight
 * @property {string | null} [language]
 */

/** The response to a FilmRequest.
 * @typedef {object} FilmState
 * @property {string} exercise
 * @property {'' | 'offered' | 'making' | 'made'} film
 * @property {number} film_share
 * @property {string} film_trouble
 * @property {true} success
 */

/** A request to control the simulation. action: one of the controls listed in the description. steps, speed, name, time_s, language: for the actions that need them.
 * @typedef {object} Control
 * @property {string} action
 * @property {number | null} [steps]
 * @property {number | null} [speed]
 * @property {string | null} [name]
 * @property {number | null} [time_s]
 * @property {string | null} [language]
 */

/** The response of a service that failed. errors: by field of a choice.
 * @typedef {object} Refused
 * @property {false} success
 * @property {string} message
 * @property {Record<string, string> | null} [errors]
 * @property {number | null} [tick]
 * @property {number | null} [age_s]
 */

/** Describe the running simulator and the names of its topics and services.
 * @param {Caller} bridge
 * @returns {Promise<Description | Refused>}
 */
export const describe = (bridge) => bridge.call('/station/describe');

/** Join under a name.
 * @param {Caller} bridge
 * @param {Join} request
 * @returns {Promise<Joined | Refused>}
 */
export const join = (bridge, { name }) => bridge.call('/station/join', { name });

/** Take control, if no other client has it.
 * @param {Caller} bridge
 * @returns {Promise<Done | Refused>}
 */
export const takeControl = (bridge) => bridge.call('/station/take_control');

/** Hand control over to another member.
 * @param {Caller} bridge
 * @param {HandOver} request
 * @returns {Promise<Done | Refused>}
 */
export const handOver = (bridge, { to }) => bridge.call('/station/hand_over', { to });

/** Set efforts; for the pilot only.
 * @param {Caller} bridge
 * @param {Drive} request
 * @returns {Promise<Driven | Refused>}
 */
export const drive = (bridge, { vehicle, surge, sway, heave, roll, pitch, yaw, stamp_ms }) =>
  bridge.call('/station/drive', { vehicle, surge, sway, heave, roll, pitch, yaw, stamp_ms });

/** Move an arm while the call is repeated; for the pilot only.
 * @param {Caller} bridge
 * @param {MoveArm} request
 * @returns {Promise<Driven | Refused>}
 */
export const moveArm = (bridge, { vehicle, joints, hand, camera, grip, stamp_ms }) =>
  bridge.call('/station/move_arm', { vehicle, joints, hand, camera, grip, stamp_ms });

/** Set all stop for a vehicle, or, as the pilot, release it.
 * @param {Caller} bridge
 * @param {AllStop} request
 * @returns {Promise<Commanded | Refused>}
 */
export const allStop = (bridge, { vehicle, on }) => bridge.call('/station/all_stop', { vehicle, on });

/** Issue another command; for the pilot only.
 * @param {Caller} bridge
 * @param {Order} request
 * @returns {Promise<Commanded | Refused>}
 */
export const command = (bridge, { name, vehicle, args }) => bridge.call('/station/command', { name, vehicle, args });

/** Report how the exercise stands.
 * @param {Caller} bridge
 * @returns {Promise<ExerciseState | Refused>}
 */
export const exercise = (bridge) => bridge.call('/station/exercise');

/** Become the instructor, with the instructor's token.
 * @param {Caller} bridge
 * @param {Supervise} request
 * @returns {Promise<Done | Refused>}
 */
export const supervise = (bridge, { token }) => bridge.call('/station/supervise', { token });

/** Change the trainee's world, pause, save a moment or return to it; for the instructor only.
 * @param {Caller} bridge
 * @param {Instruct} request
 * @returns {Promise<Commanded | Refused>}
 */
export const instruct = (bridge, { action, args }) => bridge.call('/station/instruct', { action, args });

/** Report the truth; for the instructor only.
 * @param {Caller} bridge
 * @returns {Promise<Overview | Refused>}
 */
export const overview = (bridge) => bridge.call('/station/overview');

/** List the kinds of faults; for the instructor only.
 * @param {Caller} bridge
 * @returns {Promise<FaultKinds | Refused>}
 */
export const faultKinds = (bridge) => bridge.call('/station/fault_kinds');

/** Describe all parameters; for the instructor only.
 * @param {Caller} bridge
 * @returns {Promise<ParameterList | Refused>}
 */
export const parameters = (bridge) => bridge.call('/station/parameters');

/** Save, fly, stop or report on a plan drawn on the chart.
 * @param {Caller} bridge
 * @param {PlanRequest} request
 * @returns {Promise<PlanState | Refused>}
 */
export const plan = (bridge, { action, vehicle, points_m, speed_m_s, name }) =>
  bridge.call('/station/plan', { action, vehicle, points_m, speed_m_s, name });

/** List inspection notes, add one, or set the comment.
 * @param {Caller} bridge
 * @param {NotesRequest} request
 * @returns {Promise<NotesState | Refused>}
 */
export const notes = (bridge, { action, vehicle, text, category, place, view }) =>
  bridge.call('/station/notes', { action, vehicle, text, category, place, view });

/** Change the rate, width and quality of a view.
 * @param {Caller} bridge
 * @param {SetView} request
 * @returns {Promise<Done | Refused>}
 */
export const setView = (bridge, { name, rate_hz, width, quality }) =>
  bridge.call('/station/set_view', { name, rate_hz, width, quality });

/** List the options of the start screen.
 * @param {Caller} bridge
 * @returns {Promise<Catalog | Refused>}
 */
export const catalog = (bridge) => bridge.call('/station/catalog');

/** Report the errors of a choice.
 * @param {Caller} bridge
 * @param {Choice} request
 * @returns {Promise<ChoiceTaken | Refused>}
 */
export const check = (
  bridge,
  {
    scenario,
    vehicle,
    sonar,
    tilt_deg,
    mission_time_s,
    seed,
    speed,
    link,
    rosbridge_host,
    rosbridge_port,
    rosbridge_ros,
    saved,
    flight,
    exercise_name,
  },
) =>
  bridge.call('/station/check', {
    scenario,
    vehicle,
    sonar,
    tilt_deg,
    mission_time_s,
    seed,
    speed,
    link,
    rosbridge_host,
    rosbridge_port,
    rosbridge_ros,
    saved,
    flight,
    exercise_name,
  });

/** Start a simulator from a choice.
 * @param {Caller} bridge
 * @param {Choice} request
 * @returns {Promise<ChoiceTaken | Refused>}
 */
export const start = (
  bridge,
  {
    scenario,
    vehicle,
    sonar,
    tilt_deg,
    mission_time_s,
    seed,
    speed,
    link,
    rosbridge_host,
    rosbridge_port,
    rosbridge_ros,
    saved,
    flight,
    exercise_name,
  },
) =>
  bridge.call('/station/start', {
    scenario,
    vehicle,
    sonar,
    tilt_deg,
    mission_time_s,
    seed,
    speed,
    link,
    rosbridge_host,
    rosbridge_port,
    rosbridge_ros,
    saved,
    flight,
    exercise_name,
  });

/** List a scenario's kinds of parts.
 * @param {Caller} bridge
 * @returns {Promise<EditForms | Refused>}
 */
export const editForms = (bridge) => bridge.call('/station/edit_forms');

/** Open, change, check, save or apply a scenario.
 * @param {Caller} bridge
 * @param {Edit} request
 * @returns {Promise<EditState | Refused>}
 */
export const edit = (
  bridge,
  { action, scenario, section, place, kind, vehicle, at_m, values, name, to, size, at, data },
) =>
  bridge.call('/station/edit', {
    action,
    scenario,
    section,
    place,
    kind,
    vehicle,
    at_m,
    values,
    name,
    to,
    size,
    at,
    data,
  });

/** Report on a flight's debriefing film, or begin to make it; of a running simulator, for the pilot only.
 * @param {Caller} bridge
 * @param {FilmRequest} request
 * @returns {Promise<FilmState | Refused>}
 */
export const film = (bridge, { flight, language }) => bridge.call('/station/film', { flight, language });

/** Pause, step, restart, save, record and similar actions; for the pilot only.
 * @param {Caller} bridge
 * @param {Control} request
 * @returns {Promise<Commanded | Refused>}
 */
export const control = (bridge, { action, steps, speed, name, time_s, language }) =>
  bridge.call('/station/control', { action, steps, speed, name, time_s, language });
