#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace uwsim {

/// The place where a tether is fastened: a point of a body, or of the world.
struct TetherEnd {
  static constexpr std::uint64_t kNoBody = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t body = kNoBody;                       ///< index in the RigidBodyWorld
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< in the body's frame, or the world's
};

/// A tether's parameters. The winch is at its first end.
struct TetherSpec {
  std::string name = "tether";
  TetherEnd first, second;
  double length_m = 50;         ///< out at the start, without load
  std::uint64_t elements = 50;  ///< at the start: their length stays, so that paying out adds some
  double diameter_m = 0.0076;
  double mass_kg_m = 0.0454;
  double axial_stiffness_n = 2e4;        ///< EA; an element under compression has none
  double bending_stiffness_n_m2 = 0.01;  ///< EI
  double axial_damping_n_s = 20;         ///< tension per rate of strain, in tension only
  // Morison's coefficients: drag per area d L across and pi d L along the tether, added mass per displaced mass.
  double normal_drag = 1.2, tangential_drag = 0.01;
  double normal_added_mass = 1, tangential_added_mass = 0;
  double friction = 0.5;            ///< on the bed
  double bed_stiffness_pa_m = 3e5;  ///< pressure of the bed per depth of the tether in it
  double breaking_load_n = std::numeric_limits<double>::infinity();
  double longest_m = 0;      ///< on the winch and out; 0: as long as it is at the start
  double shortest_m = 0;     ///< that stays out; 0: one element
  double fastest_m_s = 0;    ///< of the winch; 0: there is none
  double strongest_n = 1e9;  ///< the tension at which the winch recovers nothing

  double element_m() const { return length_m / static_cast<double>(elements); }
  /// As targets for rays: one for each element that it may have, and a second for the first.
  std::size_t tubes() const { return static_cast<std::size_t>(std::ceil(most_m() / element_m())) + 3; }
  double most_m() const { return longest_m > 0 ? longest_m : length_m; }
  double least_m() const { return shortest_m > 0 ? shortest_m : element_m(); }
  /// Throws InvalidValue naming the field.
  void check() const;
};

/// The winch's task until the next command. In every mode it stops at the shortest and the greatest length.
struct WinchCommand {
  enum class Mode : std::uint64_t { kHold, kRate, kTension };
  Mode mode = Mode::kHold;
  double value = 0;  ///< kRate: paid out [m/s]; kTension: [N]
};

}  // namespace uwsim
