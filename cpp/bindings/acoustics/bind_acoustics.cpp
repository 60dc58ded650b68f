#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "uwsim/acoustics/absorption.h"
#include "uwsim/acoustics/arrivals.h"
#include "uwsim/acoustics/detection_theory.h"
#include "uwsim/acoustics/seabed.h"
#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/acoustics/sound_path.h"
#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim::bindings {

namespace py = pybind11;

namespace {

using MaterialState = py::typing::Tuple<py::float_, py::float_, py::object, py::object, py::object>;

std::span<const double> values_of(const DoubleArray& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

SoundSpeedProfile profile(const py::object& depths_m, const py::object& speeds_m_s) {
  return SoundSpeedProfile(values_of(as_array<double>(depths_m, "depths_m", {-1})),
                           values_of(as_array<double>(speeds_m_s, "speeds_m_s", {-1})));
}

/// The end of each ray after half of its travel time; NaN for a travel time that is not finite.
py::array_t<double> soundings(const py::object& directions_world, const py::object& travel_time_s,
                              const py::object& origin_world_m, const SoundSpeedProfile& profile) {
  const auto directions = as_array<double>(directions_world, "directions_world", {-1, 3});
  const auto times = as_array<double>(travel_time_s, "travel_time_s", {directions.shape(0)});
  const Eigen::Vector3d origin = as_vector3(origin_world_m, "origin_world_m");
  require(origin.allFinite() && origin.z() <= 0, "origin_world_m", origin.transpose(),
          "must be finite and under water");
  const auto n = static_cast<std::size_t>(directions.shape(0));
  std::vector<double> points(3 * n, std::nan(""));
  {
    const double *direction = directions.data(), *time = times.data();
    const GilReleased unlocked;
    for (std::size_t k = 0; k < n; ++k, direction += 3) {
      const double level = std::hypot(direction[0], direction[1]);
      if (!std::isfinite(time[k]) || !(std::hypot(level, direction[2]) > 0)) continue;
      require(time[k] >= 0 && time[k] <= 60, "travel_time_s[" + std::to_string(k) + "]", time[k],
              "s: must be in [0, 60] s, or not finite for no echo");
      const SoundState end = travel(profile, -origin.z(), std::atan2(-direction[2], level), 0.5 * time[k]);
      const double share = level > 0 ? end.across_m / level : 0;
      points[3 * k] = origin.x() + share * direction[0];
      points[3 * k + 1] = origin.y() + share * direction[1];
      points[3 * k + 2] = -end.depth_m;
    }
  }
  return move_out(std::move(points), {static_cast<py::ssize_t>(n), 3});
}

void bind_water_sound(py::module_& m) {
  m.def("absorption_db_km", &absorption_db_km, py::arg("frequency_hz"), py::arg("temperature_deg_c"),
        py::arg("salinity_psu"), py::arg("depth_m"), py::arg("acidity_ph") = 8.0,
        "Return the absorption of sound in water [dB/km] by Francois and Garrison 1982. Raises ValueError.");
  py::class_<SoundSpeedProfile>(m, "SoundSpeedProfile",
                                "Speed of sound by depth: linear between levels, constant above and below them.")
      .def(py::init(&profile), py::arg("depths_m"), py::arg("speeds_m_s"),
           "Create a profile from two arrays (n,), with increasing depths. Raises ValueError naming the level.")
      .def_static("even", &SoundSpeedProfile::even, py::arg("speed_m_s"),
                  "Return a profile with the same speed at all depths, in which rays are straight.")
      .def("at", &SoundSpeedProfile::at, py::arg("depth_m"), "Return the speed [m/s] at a depth [m].");
  m.def("soundings", &soundings, py::arg("directions_world"), py::arg("travel_time_s"), py::arg("origin_world_m"),
        py::arg("profile"),
        "Return soundings as a survey computes them, (n, 3) float64, world frame: rays are traced from the\n"
        "transmitted directions_world (n, 3) for half of the two-way travel_time_s (n,), through `profile`,\n"
        "which may differ from the true one. The result is NaN for a time that is not finite. Raises\n"
        "ValueError. Releases the GIL.");
}

void bind_sonar_equation(py::module_& m) {
  py::class_<SonarParameters>(
      m, "SonarParameters",
      "Parameters of an active sonar: transmitter, receiver and detector. Levels re 1 uPa (at 1 m).")
      .def(py::init<>())
      .def_readwrite("frequency_hz", &SonarParameters::frequency_hz)
      .def_readwrite("beam_width_along_rad", &SonarParameters::beam_width_along_rad,
                     "-3 dB width, one way, of the transmitter, across the fan's plane")
      .def_readwrite("beam_width_across_rad", &SonarParameters::beam_width_across_rad,
                     "-3 dB width, one way, of a receiving beam, within the fan's plane")
      .def_readwrite("pulse_length_s", &SonarParameters::pulse_length_s)
      .def_readwrite("bandwidth_hz", &SonarParameters::bandwidth_hz)
      .def_readwrite("source_level_db", &SonarParameters::source_level_db)
      .def_readwrite("directivity_index_db", &SonarParameters::directivity_index_db)
      .def_readwrite("noise_level_db", &SonarParameters::noise_level_db, "noise level in the receiver's band")
      .def_readwrite("detection_threshold_db", &SonarParameters::detection_threshold_db,
                     "signal-to-noise ratio at which a single look is detected half of the time")
      .def_property_readonly("processing_gain_db", &SonarParameters::processing_gain_db,
                             "10 log10 (bandwidth x pulse length)")
      .def_property_readonly("lossless_snr_db", &SonarParameters::lossless_snr_db, "SL + processing gain + DI - NL")
      .def("range_cell_m", &SonarParameters::range_cell_m, py::arg("sound_speed_m_s"))
      .def("check", &SonarParameters::check, "Raise ValueError naming the field if a parameter is invalid.");
  const auto make = [](double strength_db, double relief, const std::optional<std::string>& name,
                       const std::array<double, 3>& fluid, std::optional<double> ripples_rad) {
    return BottomMaterial{
        strength_db, relief, name ? &seabed(*name) : nullptr, {fluid[0], fluid[1], fluid[2]}, ripples_rad};
  };
  const auto seabed_name = [](const BottomMaterial& bottom) -> std::optional<std::string> {
    if (!bottom.seabed) return std::nullopt;
    return std::string(bottom.seabed->name);
  };
  const auto fluid = [](const BottomMaterial& bottom) {
    return std::array<double, 3>{bottom.fluid.density_ratio, bottom.fluid.speed_ratio,
                                 bottom.fluid.attenuation_db_wavelength};
  };
  py::class_<BottomMaterial>(m, "BottomMaterial", "The acoustic backscattering properties of a bottom.")
      .def(
          py::init(make), py::arg("strength_db") = -30.0, py::arg("relief") = 0.1, py::arg("seabed") = py::none(),
          py::arg("fluid") = std::array<double, 3>{1.9, 1.1, 0.8}, py::arg("ripples_rad") = py::none(),
          "Create a material. seabed: one of seabeds(), whose backscatter by angle replaces Lambert's law. fluid: the\n"
          "density and speed of sound relative to water, and the attenuation [dB per wavelength], by which it "
          "reflects\n"
          "sound that bounces more than once. ripples_rad: direction across ripples of sand, from x to y. Raises\n"
          "ValueError for an unknown seabed.")
      .def_readonly("strength_db", &BottomMaterial::strength_db,
                    "backscatter per square metre at normal incidence; other angles follow Lambert's law")
      .def_readonly("relief", &BottomMaterial::relief, "rms slope of the relief across a footprint")
      .def_property_readonly("seabed", seabed_name,
                             "the seabed whose backscatter by angle replaces Lambert's law, or None")
      .def_property_readonly("fluid", fluid,
                             "density and speed of sound relative to water, attenuation [dB per wavelength]")
      .def_readonly("ripples_rad", &BottomMaterial::ripples_rad,
                    "direction across ripples of sand, from x to y, or None")
      .def(py::pickle(
          [seabed_name, fluid](const BottomMaterial& bottom) {
            return MaterialState(py::make_tuple(bottom.strength_db, bottom.relief, seabed_name(bottom), fluid(bottom),
                                                bottom.ripples_rad));
          },
          [make](const MaterialState& state) {
            return make(state[0].cast<double>(), state[1].cast<double>(), state[2].cast<std::optional<std::string>>(),
                        state[3].cast<std::array<double, 3>>(), state[4].cast<std::optional<double>>());
          }));
  m.def(
      "seabeds",
      [] {
        py::typing::Dict<py::str, py::typing::Tuple<py::float_, py::float_, py::float_>> all;
        for (const Seabed& s : seabeds()) {
          all[py::str(std::string(s.name))] =
              py::make_tuple(s.density_ratio, s.speed_ratio, s.attenuation_db_wavelength());
        }
        return all;
      },
      "Return the seabeds of APL-UW TR 9407, table 2, by name: density and speed of sound relative to water, and the\n"
      "attenuation [dB per wavelength].");
  m.def(
      "seabed_backscatter_db",
      [](const std::string& name, const py::object& grazing_rad, double frequency_hz, double sound_speed_m_s) {
        const auto angles = as_array<double>(grazing_rad, "grazing_rad", {-1});
        const SeabedBackscatter backscatter(seabed(name), frequency_hz, sound_speed_m_s);
        std::vector<double> levels_db;
        for (py::ssize_t k = 0; k < angles.size(); ++k) {
          const double angle_rad = *angles.data(k);
          require(angle_rad >= 0 && angle_rad <= std::numbers::pi / 2, "grazing_rad[" + std::to_string(k) + "]",
                  angle_rad, "must be in [0, pi/2] rad");
          levels_db.push_back(10 * std::log10(backscatter(angle_rad)));
        }
        return py::array(move_out(std::move(levels_db)));
      },
      py::arg("seabed"), py::arg("grazing_rad"), py::arg("frequency_hz"), py::arg("sound_speed_m_s") = 1500.0,
      "Return the backscattering strength [dB per square metre] of a seabed at grazing angles (n,), (n,) float64, by\n"
      "APL-UW TR 9407, ch. IV. Raises ValueError for an unknown seabed, or outside of 10 to 100 kHz, 1400 to 1600 m/s\n"
      "and [0, pi/2].");
  m.def(
      "bottom_echo",
      [](const SonarParameters& sonar, const BottomMaterial& bottom, double range_m, double incidence_rad,
         double steering_rad, double sound_speed_m_s, double absorption_db_m) {
        const BottomPlace place{range_m, incidence_rad, steering_rad};
        const double looks =
            averaged_looks(echo_extent_m(sonar, bottom, place, sound_speed_m_s), sonar.range_cell_m(sound_speed_m_s));
        const double snr_db = echo_snr_db(sonar, bottom, place, sound_speed_m_s, absorption_db_m);
        const double needed = DetectionThreshold(sonar.detection_threshold_db).needed_snr(looks);
        return py::make_tuple(snr_db, looks, 10 * std::log10(needed));
      },
      py::arg("sonar"), py::arg("bottom"), py::arg("range_m"), py::arg("incidence_rad"), py::arg("steering_rad"),
      py::arg("sound_speed_m_s"), py::arg("absorption_db_m"),
      "Return, for the echo of a plane bottom, its signal-to-noise ratio [dB] by the active sonar equation,\n"
      "the number of looks that the detector averages, and the ratio [dB] at which half of such echoes are\n"
      "detected.");
}

void bind_arrivals(py::module_& m) {
  py::class_<Arrival>(m, "Arrival", "Sound that arrives along one ray; see cpp/uwsim/acoustics/arrivals.h.")
      .def_readonly("surface_bounces", &Arrival::surface_bounces)
      .def_readonly("bottom_bounces", &Arrival::bottom_bounces)
      .def_readonly("turns", &Arrival::turns)
      .def_readonly("launch_dip_rad", &Arrival::launch_dip_rad, "below the horizontal")
      .def_readonly("arrival_dip_rad", &Arrival::arrival_dip_rad, "below the horizontal, in the direction of travel")
      .def_readonly("time_s", &Arrival::time_s)
      .def_readonly("length_m", &Arrival::length_m)
      .def_readonly("level_db", &Arrival::level_db, "relative to the source's level at 1 m")
      .def_readonly("phase_rad", &Arrival::phase_rad);
  m.def(
      "arrivals",
      [](const SoundSpeedProfile& profile, double from_depth_m, double to_depth_m, double across_m, double bottom_m,
         double frequency_hz, const std::array<double, 3>& bottom, double surface_rms_m, double absorption_db_km,
         double within_db, std::size_t most, int most_bounces) {
        const auto even = [absorption_db_km](double) { return absorption_db_km; };
        const AbsorptionColumn absorption(even, 1, 2);
        const SoundLosses losses{frequency_hz, {bottom[0], bottom[1], bottom[2]}, surface_rms_m, &absorption};
        const GilReleased unlocked;
        return arrivals(profile, {from_depth_m, to_depth_m, across_m, bottom_m}, losses,
                        {within_db, most, most_bounces});
      },
      py::arg("profile"), py::arg("from_depth_m"), py::arg("to_depth_m"), py::arg("across_m"), py::arg("bottom_m"),
      py::arg("frequency_hz"), py::arg("bottom"), py::arg("surface_rms_m") = 0.0, py::arg("absorption_db_km") = 0.0,
      py::arg("within_db") = 40.0, py::arg("most") = std::size_t{500}, py::arg("most_bounces") = 1000,
      "Return all arrivals between two points, sorted by time. bottom: its density and speed of sound relative to\n"
      "the water, and its attenuation [dB per wavelength]. Raises ValueError. Releases the GIL.");
}

}  // namespace

void bind_acoustics(py::module_& m) {
  bind_water_sound(m);
  bind_arrivals(m);
  bind_sonar_equation(m);
}

}  // namespace uwsim::bindings
