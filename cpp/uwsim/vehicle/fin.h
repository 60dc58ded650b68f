#pragma once

#include <Eigen/Core>
#include <string>

#include "uwsim/core/body_state.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/vehicle/slipstream.h"

namespace uwsim {

/// A lifting surface, fixed or turning about its span, in the body frame.
struct FinParameters {
  std::string name;
  Eigen::Vector3d position_body_m = Eigen::Vector3d::Zero();  ///< centre of pressure
  Eigen::Vector3d span_body = Eigen::Vector3d::UnitY();       ///< unit, perpendicular to x; deflections turn about it
  double area_m2 = 0.01;
  double aspect_ratio = 2;            ///< effective: span^2 / area, doubled if the hull acts as a reflecting plane
  double parasitic_drag = 0;          ///< C_D at zero lift, referred to area_m2
  double efficiency = 0.9;            ///< Oswald efficiency factor for the induced drag
  double stall_angle_rad = 0.35;      ///< angle at which lift is midway between attached flow and a flat plate
  double stall_sharpness_rad = 0.04;  ///< e-folding angle of that transition
  bool stalls = true;                 ///< if false, the flow stays attached at every angle
  double deflection_max_rad = 0;      ///< 0 for a fixed fin
  double rate_max_rad_s = 1;
  std::string slipstream_of;  ///< the thruster in whose slipstream it may be, as a rudder is; none if empty

  /// Throws InvalidValue naming the fin and the field.
  void check() const;
  /// dC_L / d alpha at zero lift [1/rad]: pi A / (1 + sqrt(1 + (A / 2)^2)), where A is the aspect ratio (Beard and
  /// McLain 2012, "Small Unmanned Aircraft", ch. 4; Fossen 2021 uses the same for AUVs).
  double lift_slope() const;
};

/// A fin that follows its commanded deflection at a limited rate.
///
/// Lift and drag act at the centre of pressure, in the plane perpendicular to the span, for the flow at that point
/// (Beard and McLain 2012, ch. 4). Below stall, C_L = C_La sin a cos a (within 2 % of C_La a up to 10 degrees, and
/// bounded in flow from behind) and C_D = C_D0 + C_L^2 / (pi e A). Beyond stall, the coefficients of a flat plate
/// apply: C_L = 2 sin^2 a cos a and C_D = C_D0 + 2 |sin^3 a|. A sigmoid blends the two. Quasi-steady: no wake, no added
/// mass, no flow along the span. The share of the span that is in a propeller's slipstream has that flow instead; its
/// force, too, acts at the centre of pressure.
class Fin {
 public:
  /// Throws InvalidValue; see FinParameters::check.
  explicit Fin(FinParameters parameters);

  const FinParameters& parameters() const { return parameters_; }
  /// Force and moment about the body's origin per 1 rad of deflection and 1 N/m^2 of dynamic pressure in flow from
  /// ahead.
  Vector6d column() const;

  /// Sets the commanded deflection, which stays in effect until the next command. The caller checks the limit.
  void set_command(double angle_rad) { command_rad_ = angle_rad; }
  double command_rad() const { return command_rad_; }
  /// Turns the fin for one step.
  void advance(double step_s);
  /// The deflection, right-handed about the span axis.
  double angle_rad() const { return angle_rad_; }

  struct Coefficients {
    double lift = 0, drag = 0;
  };
  Coefficients coefficients(double attack_rad) const;
  /// Adds force and moment (body frame, at the origin) for a vehicle that moves at `through_water` (6,) [m/s, rad/s]
  /// with the fraction `submerged` of the fin under water.
  void add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, Vector6d& tau_body) const;
  /// The same in a slipstream.
  void add_wrench(const Vector6d& through_water, double density_kg_m3, double submerged, const Slipstream& jet,
                  Vector6d& tau_body) const;
  /// Fraction of the fin below a level surface `height_m` above its centre. `span_up`: vertical component of the span.
  double submerged_fraction(double height_m, double span_up) const;

  /// Saves or restores command and deflection.
  void exchange_state(StateArchive& archive);

 private:
  void add_force(const Eigen::Vector3d& velocity, double density_kg_m3, double submerged, Vector6d& tau_body) const;

  FinParameters parameters_;
  double lift_slope_;
  double induced_drag_;  // 1 / (pi e A)
  double half_span_m_;
  double command_rad_ = 0;
  double angle_rad_ = 0;
};

}  // namespace uwsim
