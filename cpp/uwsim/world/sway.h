#pragma once

#include <Eigen/Core>
#include <memory>

#include "uwsim/world/world.h"

namespace uwsim {

/// How plants lean with the water at one time: a function of place and time, so that nothing of it is saved.
///
/// A plant of height L is a rod without mass on a hinge. Its buoyancy rights it, and the drag on it is that of the
/// water that passes it, so that its top, at a distance x from above its foot, follows
///
///   |u - dx/dt| (u - dx/dt) = u_1^2 x / L,
///
/// where u_1 is the speed of a steady current in which it leans by 45 degrees (drag equal to buoyancy; Luhar and Nepf
/// 2011, Limnol. Oceanogr. 56:2003, their limit without stiffness). The drag is linearised about the current U and the
/// waves' rms speed s: |u - dx/dt| becomes w = sqrt(U^2 + 8 s^2 / pi) (Borgman 1967, J. Geophys. Res. 72:2061, for the
/// waves alone). Then x = U w L / u_1^2 in a current, and each wave moves the top as a spring of rate u_1^2 / (w L)
/// does: in phase with the velocity if the plant is stiff, and at most as far as the water itself (Luhar and Nepf 2016,
/// J. Fluids Struct. 61:20, for blades that are long compared with the water's excursion).
///
/// All plants of a layer are as high as its geometric mean here, u is that at two thirds of their height, and
/// neighbours lean alike. They do not slow the water.
class Sway {
 public:
  /// Null if no cover of the world sways, or if its water never moves.
  static std::shared_ptr<const Sway> of(const World& world, double time_s);

  /// Returns true if the other's plants lean the same, as far as is known without comparing waters part by part.
  bool same_as(const Sway& other) const;
  /// The horizontal displacement of a plant's top, of its height: the tangent of its lean, by its direction.
  Eigen::Vector2d lean(const CoverLayer& layer, const Eigen::Vector3d& foot_world_m) const;

  Sway(const Water& water, double time_s);

 private:
  Water current_;  // without waves
  std::shared_ptr<const Waves> waves_;
  double time_s_, level_m_;
};

}  // namespace uwsim
