#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/integrator.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The wrenches of waves on a hull, body frame, at the origin [N, N m]. radiation: of the waves that the hull makes by
/// moving. diffraction: of the sea's waves, as the hull deflects them.
struct HullWaveWrenches {
  Vector6d radiation = Vector6d::Zero(), diffraction = Vector6d::Zero();
};

/// The memory of the waves that a floating hull has made, and the sea that it deflects (vehicle/radiation.h).
///
/// A step is that of `advance` (classical Runge-Kutta) with body and resonators together. Both sides of the resonators
/// are weighted by the square root of the share s of Radiation, so that they take energy from the body at any share:
///
///   y'' = sqrt(s) nu - 2 zeta omega y' - omega^2 y,   force = -sqrt(s) (R y' + Q y)
///
/// Diffraction is the sum over the sea's waves at the body's position, for its heading at the start of the step, with
/// the slow drift, if the table has it.
class HullWaves {
 public:
  /// Throws InvalidValue, which names the body, if more than `kLeftOut` of the energy of the water's waves is beyond
  /// the frequencies of the hull's table, or a resonator is too fast for a step.
  HullWaves(const std::string& body, std::shared_ptr<const Craft> craft, const Water& water, double step_s);

  static constexpr double kLeftOut = 0.02;

  /// Continues with another's memory, if it has as many resonators.
  void remember(const HullWaves& other);
  /// The water around is as if the hull had always been at rest.
  void forget();
  /// Starts a step at the present state.
  void begin() { start_ = now_; }
  /// Returns the body's state at the end of a step, or part of one, from `state`, and finds that of the resonators.
  BodyState advance(const BodyState& state, const Loads& loads, const WaterField& water, double time_s, double step_s);
  /// The waves that the hull made run out while it is held.
  void run_out(double step_s);
  /// Continues from the end of the part.
  void next_part() { start_ = next_; }
  /// The step is made.
  void accept() { now_ = next_; }

  /// The wrenches in each stage of the last advance().
  const std::array<HullWaveWrenches, 4>& stage_wrenches() const { return wrenches_; }
  /// The wrenches at this instant.
  HullWaveWrenches wrenches_at(const BodyState& state, const WaterField& water, double time_s) const;

  /// Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  /// The resonators of a section.
  struct Resonator {
    Vector6d place = Vector6d::Zero(), speed = Vector6d::Zero();
  };
  struct Component {
    WaveComponent wave;
    Eigen::Vector2d number_rad_m;
  };
  using Resonators = std::vector<Resonator>;
  /// On the hull in each component, in the level axes that it heads along; no drift if the table has none.
  struct Forces {
    std::vector<Radiation::Force> first_order;
    std::vector<Radiation::Drift> drift;
  };

  void face(double heading_rad, Forces& forces) const;
  Vector6d deflected(const Forces& forces, const Eigen::Vector3d& position_m, double time_s) const;
  HullWaveWrenches wrenches(const Resonators& resonators, const Forces& forces, const BodyState& state, double share,
                            double time_s) const;
  void rates(const Resonators& resonators, const Vector6d& drive_body, Resonators& out) const;
  void runge_kutta_stage(std::size_t stage, double step_s);

  std::shared_ptr<const Craft> craft_;
  std::vector<Component> components_;
  std::size_t division_ = 0;  // of the hull at the surface
  Resonators now_, start_, next_;
  // The step under way, kept so that steps allocate nothing.
  Resonators stage_, rate_;
  Forces forces_;
  std::array<HullWaveWrenches, 4> wrenches_;
};

}  // namespace uwsim
