#pragma once

#include <Eigen/Core>
#include <string>

#include "uwsim/core/body_state.h"
#include "uwsim/core/state_archive.h"

namespace uwsim {

/// A lifting surface, body frame: a fin that turns about its span, or one that is fixed.
struct FinParameters {
  std::string name;
  Eigen::Vector3d position_body_m = Eigen::Vector3d::Zero();  ///< centre of pressure
  Eigen::Vector3d span_body = Eigen::Vector3d::UnitY();       ///< unit, across x; a deflection turns about it
  double area_m2 = 0.01;
  double aspect_ratio = 2;            ///< effective: span^2 / area, doubled where the hull mirrors the fin
  double parasitic_drag = 0;          ///< C_D at no lift, of the area
  double efficiency = 0.9;            ///< Oswald's, of the induced drag
  double stall_angle_rad = 0.35;      ///< where half of the lift's excess over a flat plate's is gone
  double stall_sharpness_rad = 0.04;  ///< e-folding angle of that
  bool stalls = true;
  double deflection_max_rad = 0;  ///< 0: fixed
  double rate_max_rad_s = 1;

  /// Throws InvalidValue that names fin and field.
  void check() const;
  /// dC_L / d alpha at no lift [1/rad]: pi A / (1 + sqrt(1 + (A / 2)^2)), A the aspect ratio (Beard and McLain 2012,
  /// "Small Unmanned Aircraft", ch. 4; Fossen 2021 takes the same for AUVs).
  double lift_slope() const;
};

/// A fin that follows its commanded deflection at a limited rate.
///
/// Lift and drag act at the centre of pressure, in the plane across the span, on the flow there. After Beard and McLain
/// 2012, ch. 4: below stall C_L = C_La sin a cos a (within 2 % of C_La a to 10 degrees, and bounded in flow from
/// behind), C_D = C_D0 + C_L^2 / (pi e A); past it the flat plate's C_L = 2 sin^2 a cos a, C_D = C_D0 + 2 |sin^3 a|;
/// blended by their sigmoid. Quasi-steady: no wake, no added mass, no flow along the span.
class Fin {
 public:
  /// Throws InvalidValue from the parameters' check.
  explicit Fin(FinParameters parameters);

  const FinParameters& parameters() const { return parameters_; }
  /// Force and moment about the origin per radian of deflection and N/m^2 of dynamic pressure in flow from ahead.
  Vector6d column() const;

  /// Held; checked by the caller.
  void set_command(double angle_rad) { command_rad_ = angle_rad; }
  double command_rad() const { return command_rad_; }
  void advance(double step_s);
  /// About the span, right-handed.
  double angle_rad() const { return angle_rad_; }

  struct Coefficients {
    double lift = 0, drag = 0;
  };
  Coefficients coefficients(double attack_rad) const;
  /// Adds force and moment (body frame, at the origin) of a vehicle that moves with `through_water` (6,).
  void add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, Vector6d& tau_body) const;
  /// Share of the fin under a level surface `height_m` above its centre; `span_up` is the vertical part of the span.
  double submerged_share(double height_m, double span_up) const;

  /// Saves or restores how it stands.
  void exchange_state(StateArchive& archive);

 private:
  FinParameters parameters_;
  double lift_slope_;
  double induced_drag_;  // 1 / (pi e A)
  double half_span_m_;
  double command_rad_ = 0;
  double angle_rad_ = 0;
};

}  // namespace uwsim
