#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "bindings/world/binders.h"
#include "uwsim/core/check.h"
#include "uwsim/world/waves.h"

namespace uwsim::bindings {

namespace py = pybind11;

namespace {

std::shared_ptr<Waves> airy(double amplitude_m, double period_s, double heading_rad, double phase_rad, double depth_m,
                            double gravity_m_s2) {
  require(period_s > 0, "water.surface.period_s", period_s, "must be positive");
  const WaveComponent wave{amplitude_m, 2 * std::numbers::pi / period_s, heading_rad, phase_rad};
  return std::make_shared<Waves>(std::span(&wave, 1), depth_m, gravity_m_s2);
}

Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> components(const Waves& waves) {
  const std::vector<WaveComponent> all = waves.components();
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> rows(static_cast<Eigen::Index>(all.size()), 4);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const WaveComponent& wave = all[static_cast<std::size_t>(k)];
    rows.row(k) << wave.amplitude_m, wave.angular_frequency_rad_s, wave.heading_rad, wave.phase_rad;
  }
  return rows;
}

}  // namespace

void bind_waves(py::module_& m) {
  py::class_<Waves, std::shared_ptr<Waves>>(
      m, "Waves", "Linear (Airy) waves on water of constant depth, with Wheeler's stretching (1970) near the surface.")
      .def_static("airy", &airy, py::arg("amplitude_m"), py::arg("period_s"), py::arg("heading_rad") = 0.0,
                  py::arg("phase_rad") = 0.0, py::arg("depth_m") = std::numeric_limits<double>::infinity(),
                  py::arg("gravity_m_s2") = 9.80665,
                  "Return a single wave that propagates towards heading_rad (from east, counter-clockwise). Raises\n"
                  "ValueError.")
      .def_static(
          "jonswap",
          [](double height, double period, double enhancement, double heading, double spreading, int count,
             std::uint64_t seed, double depth_m, double gravity) {
            return std::make_shared<Waves>(
                Waves::jonswap({height, period, enhancement, heading, spreading, count, seed}, depth_m, gravity));
          },
          py::arg("significant_height_m"), py::arg("peak_period_s"), py::arg("peak_enhancement") = 3.3,
          py::arg("heading_rad") = 0.0, py::arg("spreading_exponent") = 0.0, py::arg("component_count") = 64,
          py::arg("seed") = 0, py::arg("depth_m") = std::numeric_limits<double>::infinity(),
          py::arg("gravity_m_s2") = 9.80665,
          "Return a sea of component_count waves with a JONSWAP spectrum, or the TMA spectrum in finite depth.\n"
          "Raises ValueError.")
      .def_property_readonly("components", &components,
                             "(n, 4): amplitude [m], angular frequency [rad/s], heading and phase [rad] of each wave")
      .def_property_readonly("significant_height_m", &Waves::significant_height_m, "4 sqrt(m0)")
      .def_property_readonly("bound_m", &Waves::bound_m,
                             "the sum of the amplitudes: no crest is higher, no trough deeper")
      .def_property_readonly("depth_m", &Waves::depth_m);
}

}  // namespace uwsim::bindings
