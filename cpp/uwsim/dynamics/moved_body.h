#pragma once

#include <memory>
#include <string>
#include <vector>

#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/vehicle/hydrodynamics.h"

namespace uwsim {

inline constexpr double kDiverged = 1e7;  ///< m, m/s and rad/s: only a diverging body gets this far

/// A craft and its collision properties.
struct BodySpec {
  std::string name;
  std::shared_ptr<const Craft> craft;
  CollisionShape shape = CollisionShape::kHull;
  /// Coulomb friction coefficient; a pair of bodies uses the geometric mean of both
  double friction = 0.5;
  /// 0 (inelastic) to 1 (elastic); a pair of bodies uses the larger value
  double restitution = 0.1;
  std::vector<ConvexPiece> collision_pieces_body_m = {};  ///< for CollisionShape::kPieces

  /// Throws InvalidValue naming the field.
  void check() const;
};

double pair_friction(const BodySpec& a, const BodySpec& b);
double pair_restitution(const BodySpec& a, const BodySpec& b);

/// A body of a RigidBodyWorld.
struct MovedBody {
  BodySpec spec;  ///< includes its collision pieces for every shape
  BodyState state;
  Vector6d tau_body = Vector6d::Zero();
  Vector6d acceleration_body = Vector6d::Zero();
  bool held = false;
  bool in_contact = false;

  /// Throws InvalidValue, which names step and body, unless `next` is a plausible state for it.
  void require_plausible(const BodyState& next, double time_s, double step_s) const;
};

}  // namespace uwsim
