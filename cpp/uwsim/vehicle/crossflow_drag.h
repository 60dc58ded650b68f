#pragma once

namespace uwsim {

/// Drag across a hull in strips along its length, each with the drag of its own speed (the cross-flow principle:
/// Hoerner 1965, "Fluid-Dynamic Drag", ch. III; Allen and Perkins 1951, NACA Report 1048; Prestero 2001, "Verification
/// of a Six-Degree of Freedom Simulation Model for the REMUS AUV", sec. 4.1): at x, -K/L |v + x w| (v + x w) per metre.
/// Strips couple moving across and turning: each damps the other. Valid for flow that separates along the whole length,
/// with a drag coefficient that does not depend on speed; the strips are equal, and centred on the origin.
class CrossflowDrag {
 public:
  struct Load {
    double force = 0;   ///< across [N]
    double moment = 0;  ///< integral of x times the force per metre [N m]
  };

  CrossflowDrag() = default;
  /// `across` [N s^2/m^2] and `turning` [N m s^2/rad^2]: the hull's whole coefficients, which also hold for the strips:
  /// these are shorter than `length_m` where their own drag in turning, across length_m^3 / 32, would exceed `turning`.
  CrossflowDrag(double across, double turning, double length_m);

  /// The drag in turning alone, at the origin: -turning_drag() |w| w [N m s^2/rad^2].
  double turning_drag() const;
  /// For the speed across v at the origin [m/s] and the rate w [rad/s].
  Load load(double across_m_s, double turn_rad_s) const;

 private:
  double across_ = 0, half_length_m_ = 0;
};

}  // namespace uwsim
