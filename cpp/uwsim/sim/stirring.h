#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/rigid_body_world.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/sim/vehicle.h"
#include "uwsim/world/sediment.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// The sediment that propellers lift off the terrain, and the clouds of it in the water.
///
/// Twice a second, each propeller's jet that meets the terrain within 60 degrees of its normal erodes it as an
/// ImpingingJet of its thrust's part along the normal, at the distance along the jet, at least 8.3 diameters, even if
/// the thruster is nearer. What it lifts is a cloud as wide as the eroded area, as high as the wall jet at its rim
/// (0.087 of the radius, Rajaratnam 1976, "Turbulent Jets"), which joins a cloud that it overlaps. Clouds drift with
/// the water over the bed, spread and settle; above 256, the thinnest is left out. Jets are those of propellers in
/// still water: hulls do not stand in their way, nor does one jet feel another, and the bed does not wear down.
class Stirring {
 public:
  explicit Stirring(const Sediment& sediment) : clouds_{(sediment.check(), sediment), {}} {}

  /// Advances by one step, which ends at `tick`.
  void advance(std::span<const Vehicle> vehicles, const RigidBodyWorld& bodies, const World& world,
               const RayScene& scene, std::uint64_t tick, double step_s);
  const SedimentClouds& clouds() const { return clouds_; }

  void exchange_state(StateArchive& archive);

 private:
  void lift(const Thruster& thruster, const Pose& world_from_body, const RayScene& scene, double period_s);
  void join(const SedimentCloud& fresh);

  SedimentClouds clouds_;
};

}  // namespace uwsim
