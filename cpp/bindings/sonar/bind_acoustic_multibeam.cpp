#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "bindings/core/record.h"
#include "bindings/sonar/binders.h"
#include "bindings/sonar/physics_ping.h"
#include "uwsim/sonar/acoustic_multibeam.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim::bindings {
namespace {

std::string describe(const PhysicsPing& ping) {
  return describe_fan("PhysicsPing", ping.ranges_m, ping.valid, ping.time_ns);
}

void bind_ping(py::module_& m) {
  py::enum_<Detection>(m, "Detection", "The method by which a beam's range was detected.")
      .value("NONE", Detection::kNone)
      .value("AMPLITUDE", Detection::kAmplitude)
      .value("PHASE", Detection::kPhase)
      .value("FALSE", Detection::kFalse, "noise detected as an echo");
  Record<PhysicsPing>(
      m, "PhysicsPing",
      "One multibeam ping in physics mode: the arrays of Ping and more, read-only, with one value per beam.",
      py::dynamic_attr())
      .field("model", &PhysicsPing::model, "EM 2040 variant 1..4; 0 for a model that messages cannot select")
      .field("time_ns", &PhysicsPing::time_ns)
      .field("world_from_sonar", &PhysicsPing::world_from_sonar, "(4, 4) float64, at transmission")
      .field("ranges_m", &PhysicsPing::ranges_m,
             "(beams,) float32, sound speed at the head x half the travel time; inf for no detection")
      .field("angles_rad", &PhysicsPing::angles_rad, "(beams,) float32, about +z of the sonar, positive to port")
      .field("points_sonar_m", &PhysicsPing::points_sonar_m,
             "(beams, 3) float32, the range along the beam's axis; NaN for no detection")
      .field(
          "incidence_rad", &PhysicsPing::incidence_rad,
          "(beams,) float32 in [0, pi/2], true value; NaN for no detection, a false one, a ghost or a target in the\n"
          "water")
      .field("intensity_db", &PhysicsPing::intensity_db,
             "(beams,) float32, received level minus source level, with speckle and noise; -inf for no detection")
      .field("snr_db", &PhysicsPing::snr_db,
             "(beams,) float32, signal-to-noise ratio at the detector; -inf for no detection")
      .field("travel_time_s", &PhysicsPing::travel_time_s, "(beams,) float32, two-way; inf for no detection")
      .field("deviation_m", &PhysicsPing::deviation_m,
             "(beams,) float32, standard deviation of the range, by the detector's own estimate; inf = no detection")
      .field("vertical_deviation_m", &PhysicsPing::vertical_deviation_m,
             "(beams,) float32, standard deviation of the echo's height in the world, due to the error of its range\n"
             "and the transmitter's width; inf = no detection")
      .field("horizontal_deviation_m", &PhysicsPing::horizontal_deviation_m,
             "(beams,) float32, the same for the echo's horizontal position")
      .field(
          "labels", &PhysicsPing::labels,
          "(beams,) uint16, true value, see World.label_names; 0 for no detection, a false one, a ghost or a target\n"
          "in the water")
      .field("valid", &PhysicsPing::valid, "(beams,) bool: detected, including false detections")
      .field("detections", &PhysicsPing::detections, "(beams,) uint8, values of Detection")
      .field("water_column", &PhysicsPing::water_column,
             "(beams, samples) float32 [dB], the level of each sample in the units of intensity_db, with speckle\n"
             "and noise; None unless requested. At most 4096 samples per beam, each of one or several range cells")
      .field("water_column_ranges_m", &PhysicsPing::water_column_ranges_m,
             "(samples,) float32, the middle of each sample; None unless requested")
      .described_by(&describe)
      .drawn_by("uwsim.instruments.sonars.fan_plot")
      .done();
}

void bind_spec(py::module_& m) {
  py::class_<WaterTargets>(m, "WaterTargets", "A school of fish, or the rising bubbles of a seep, as point targets.")
      .def(py::init([](std::string name, bool rises, const py::object& position_m, const py::object& size_m, int count,
                       double target_strength_db, double rise_m_s) {
             WaterTargets group{
                 std::move(name),    rises,   as_vector3(position_m, "position_m"), as_vector3(size_m, "size_m"), count,
                 target_strength_db, rise_m_s};
             group.check("target");
             return group;
           }),
           py::arg("name"), py::arg("rises"), py::arg("position_m"), py::arg("size_m"), py::arg("count"),
           py::arg("target_strength_db"), py::arg("rise_m_s") = 0.0,
           "Create a group. A school fills an ellipsoid around position_m with the diameters size_m. The bubbles of\n"
           "a seep (rises) form a cone with its tip at position_m; size_m is its diameters at the top and its\n"
           "height. target_strength_db: of each target, re 1 m^2. Raises ValueError.")
      .def_readonly("name", &WaterTargets::name)
      .def_readonly("count", &WaterTargets::count);
  m.def(
      "water_targets_at",
      [](const WaterTargets& group, std::uint64_t seed, double time_s) {
        const Eigen::MatrixX3d places = MovingTargets(group, seed).at(time_s).transpose();
        return places;
      },
      py::arg("group"), py::arg("seed"), py::arg("time_s"),
      "Return the positions of a group's targets, (count, 3) float64, world frame.");
  py::class_<AcousticSpec>(m, "AcousticSpec", "The acoustic parameters of a multibeam in physics mode.")
      .def(py::init<>())
      .def_readwrite("parameters", &AcousticSpec::parameters)
      .def_readwrite("rays_per_beam", &AcousticSpec::rays_per_beam, "rays per beam: 1, or 4 to 64")
      .def_readwrite("false_detections", &AcousticSpec::false_detections)
      .def_readwrite("range_noise", &AcousticSpec::range_noise)
      .def_readwrite("bending", &AcousticSpec::bending, "Whether rays follow the sound-speed profile.")
      .def_readwrite("multipath", &AcousticSpec::multipath, "Whether echoes with several bounces are received.")
      .def_readwrite("volume_strength_db", &AcousticSpec::volume_strength_db,
                     "backscatter per cubic metre of water [dB]; None for none")
      .def_readwrite("targets", &AcousticSpec::targets, "fish and bubbles in the water")
      .def_readwrite("acidity_ph", &AcousticSpec::acidity_ph)
      .def_readwrite("bottom", &AcousticSpec::bottom, "for labels that `materials` does not cover")
      .def_readwrite("materials", &AcousticSpec::materials, "by label, see World.label_names")
      .def("check", &AcousticSpec::check, "Raise ValueError naming the field if a parameter is invalid.");
}

void bind_instrument(py::module_& m) {
  py::class_<AcousticMultibeam, std::shared_ptr<AcousticMultibeam>>(
      m, "AcousticMultibeam",
      "A multibeam in physics mode, independent of any vehicle. Pings do not depend on the number of threads.")
      .def(py::init([](const MultibeamModel& model, const AcousticSpec& spec, const Water& water, std::uint64_t seed,
                       const std::string& name) {
             model.check();
             return std::make_shared<AcousticMultibeam>(model, spec, water, water.bottom_depth_m,
                                                        RandomStream(seed, name));
           }),
           py::arg("model"), py::arg("spec"), py::arg("water"), py::arg("seed") = 0, py::arg("name") = "sonar",
           "Create a sonar. Raises ValueError naming the field.")
      .def_property_readonly("profile", &AcousticMultibeam::profile, "sound-speed profile of its water")
      .def(
          "ping",
          [](const AcousticMultibeam& sonar, const RayScene& scene, const py::object& position_world_m,
             const py::object& orientation_xyzw, const py::object& velocity_world_m_s,
             const py::object& rate_world_rad_s, std::uint64_t tick, int threads, double time_s, bool water_column) {
            const Pose pose = as_pose(position_world_m, orientation_xyzw, "sonar");
            const HeadMotion motion{as_vector3(velocity_world_m_s, "velocity_world_m_s"),
                                    as_vector3(rate_world_rad_s, "rate_world_rad_s")};
            require(motion.velocity_world_m_s.allFinite() && motion.velocity_world_m_s.norm() <= 100,
                    "velocity_world_m_s", motion.velocity_world_m_s.transpose(), "must be at most 100 m/s");
            require(motion.rate_world_rad_s.allFinite() && motion.rate_world_rad_s.norm() <= 100, "rate_world_rad_s",
                    motion.rate_world_rad_s.transpose(), "must be at most 100 rad/s");
            AcousticPing raw;
            {
              const GilReleased unlocked;
              raw = sonar.ping(scene, pose, motion, tick, threads, {time_s, water_column});
            }
            return physics_ping(std::move(raw), sonar.fan(), pose, 0);
          },
          py::arg("scene"), py::arg("position_world_m"), py::arg("orientation_xyzw"),
          py::arg("velocity_world_m_s") = py::make_tuple(0.0, 0.0, 0.0),
          py::arg("rate_world_rad_s") = py::make_tuple(0.0, 0.0, 0.0), py::arg("tick") = 0, py::arg("threads") = 1,
          py::arg("time_s") = 0.0, py::arg("water_column") = false,
          "Ping once from a pose (3,), (4,), with linear and angular velocity (3,), (3,) in world axes. Random\n"
          "draws are keyed by tick; bubbles move with time_s. Raises ValueError. Releases the GIL.");
  m.def("sound_speed_profile", &sound_speed_profile, py::arg("water"),
        "Return the speed of sound by depth: that of the water's profile if it specifies one, else by its equation.");
}

}  // namespace

std::string describe_fan(const char* name, const py::array& ranges_m, const py::array& valid, std::uint64_t time_ns) {
  const py::array_t<float> ranges(ranges_m);
  const py::array_t<bool> heard(valid);
  py::ssize_t echoes = 0;
  float nearest = std::numeric_limits<float>::infinity(), farthest = 0;
  for (py::ssize_t beam = 0; beam < ranges.size(); ++beam) {
    if (!heard.at(beam)) continue;
    ++echoes;
    nearest = std::min(nearest, ranges.at(beam));
    farthest = std::max(farthest, ranges.at(beam));
  }
  char text[160];
  std::snprintf(text, sizeof text, "%s(t = %.3f s: %zu beams, ", name, static_cast<double>(time_ns) * 1e-9,
                static_cast<std::size_t>(ranges.size()));
  std::string line = text;
  if (echoes == 0) return line + "no echo)";
  std::snprintf(text, sizeof text, "%zu echoes, %.2f to %.2f m)", static_cast<std::size_t>(echoes),
                static_cast<double>(nearest), static_cast<double>(farthest));
  return line + text;
}

PhysicsPing physics_ping(AcousticPing&& ping, const MultibeamModel& fan, const Pose& world_from_sonar,
                         std::uint64_t time_ns) {
  const auto beams = static_cast<py::ssize_t>(ping.ranges_m.size());
  std::vector<float> angles;
  for (int beam = 0; beam < fan.beams; ++beam) angles.push_back(static_cast<float>(fan.angles().at(beam)));
  PhysicsPing out;
  out.model = fan.number;
  out.time_ns = time_ns;
  out.world_from_sonar = world_from_sonar.matrix();
  out.ranges_m = read_only(move_out(std::move(ping.ranges_m)));
  out.angles_rad = read_only(move_out(std::move(angles)));
  out.points_sonar_m = read_only(move_out(std::move(ping.points_sonar_m), {beams, 3}));
  out.incidence_rad = read_only(move_out(std::move(ping.incidence_rad)));
  out.intensity_db = read_only(move_out(std::move(ping.intensity_db)));
  out.snr_db = read_only(move_out(std::move(ping.snr_db)));
  out.travel_time_s = read_only(move_out(std::move(ping.travel_time_s)));
  out.deviation_m = read_only(move_out(std::move(ping.deviation_m)));
  out.vertical_deviation_m = read_only(move_out(std::move(ping.vertical_deviation_m)));
  out.horizontal_deviation_m = read_only(move_out(std::move(ping.horizontal_deviation_m)));
  out.labels = read_only(move_out(std::move(ping.labels)));
  out.valid = read_only(move_out(std::move(ping.valid)).attr("view")("bool").cast<py::array_t<bool>>());
  out.detections = read_only(move_out(std::move(ping.detections)));
  if (!ping.water_column_db.empty()) {
    const auto samples = static_cast<py::ssize_t>(ping.water_column_db.size()) / beams;
    std::vector<float> ranges_m;
    for (py::ssize_t k = 0; k < samples; ++k) {
      ranges_m.push_back(static_cast<float>((static_cast<double>(k) + 0.5) * ping.water_column_sample_m));
    }
    out.water_column = read_only(move_out(std::move(ping.water_column_db), {beams, samples}));
    out.water_column_ranges_m = read_only(move_out(std::move(ranges_m)));
  }
  return out;
}

void bind_acoustic_multibeam(py::module_& m) {
  bind_ping(m);
  bind_spec(m);
  bind_instrument(m);
}

}  // namespace uwsim::bindings
