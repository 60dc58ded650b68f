#pragma once

namespace uwsim {

/// Transverse drag of a hull, integrated over strips along its length, each with its local speed (the cross-flow
/// principle: Hoerner 1965, "Fluid-Dynamic Drag", ch. III; Allen and Perkins 1951, NACA Report 1048; Prestero 2001,
/// "Verification of a Six-Degree of Freedom Simulation Model for the REMUS AUV", sec. 4.1). The force per metre at x is
/// -K/L |v + x w| (v + x w). The strips couple transverse motion and turning: each damps the other. Valid for flow that
/// separates along the whole length, with a drag coefficient that does not depend on speed. The strips are identical,
/// and centred on the origin.
class CrossflowDrag {
 public:
  struct Load {
    double force = 0;   ///< transverse [N]
    double moment = 0;  ///< integral of x times the force per metre [N m]
  };

  CrossflowDrag() = default;
  /// `across` [N s^2/m^2] and `turning` [N m s^2/rad^2]: the hull's total coefficients, which include the drag of the
  /// strips. The strips cover less than `length_m` if their own drag in turning, across length_m^3 / 32, would
  /// otherwise exceed `turning`.
  CrossflowDrag(double across, double turning, double length_m);

  /// Coefficient of the strips' moment in pure turning about the origin, -turning_drag() |w| w [N m s^2/rad^2].
  double turning_drag() const;
  /// The load at a transverse speed v of the origin [m/s] and a turning rate w [rad/s].
  Load load(double across_m_s, double turn_rad_s) const;

 private:
  double across_ = 0, half_length_m_ = 0;
};

}  // namespace uwsim
