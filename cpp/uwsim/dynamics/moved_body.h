#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/dynamics/arm.h"
#include "uwsim/dynamics/body_path.h"
#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/integrator.h"
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
  std::vector<ArmLink> arm = {};
  std::shared_ptr<const BodyPath> path = nullptr;  ///< that it follows, whatever it hits; null: forces move it
  std::optional<RoundPiece> round = {};            ///< for CollisionShape::kHull: what the mesh's facets stand for

  /// Throws InvalidValue naming the field.
  void check() const;
};

double pair_friction(const BodySpec& a, const BodySpec& b);
/// That between links of their arms; null: hulls.
double pair_friction(const BodySpec& a, const ArmLink* link_a, const BodySpec& b, const ArmLink* link_b);
double pair_restitution(const BodySpec& a, const BodySpec& b);

/// How a body was moved in a step or a part of one.
struct Motion {
  BodyState start;
  Vector6d actuators_body = Vector6d::Zero();
  Loads applied = {};
  Vector6d wind_body = Vector6d::Zero();  ///< as MovedBody has it
  Vector6d tether_world = Vector6d::Zero();
  Loads all = {};                                        ///< with those of its contacts
  std::optional<std::array<Vector6d, 4>> arm_body = {};  ///< of its arm, in each stage
  double time_s = 0, step_s = 0;
  bool stops = false;  ///< its contacts stopped it, or it stayed at rest (resting.h)
};

/// A point at which a body was pressed in a step.
struct Touch {
  std::uint64_t other = kNoBody;  ///< index of the other body; kNoBody: terrain, a solid or cover
  Eigen::Vector3d point_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_world_n = Eigen::Vector3d::Zero();  ///< on the body, mean over the step
  std::uint64_t link = kNoLink, other_link = kNoLink;       ///< of the arms of the body and of the other one

  static constexpr std::uint64_t kNoBody = std::numeric_limits<std::uint64_t>::max(), kNoLink = kNoBody;
};

/// A body of a RigidBodyWorld.
struct MovedBody {
  BodySpec spec;  ///< includes its collision pieces for every shape
  BodyState state;
  Vector6d tau_body = Vector6d::Zero();      ///< of the actuators
  Loads applied = {};                        ///< by apply_wrench and the wind
  Vector6d wind_body = Vector6d::Zero();     ///< the wind's part of `applied`
  Vector6d tether_world = Vector6d::Zero();  ///< of the tethers at it, in the step under way or the last one
  Vector6d canopy_world = Vector6d::Zero();  ///< of plants, in the step under way
  Vector6d acceleration_body = Vector6d::Zero();
  std::optional<Arm> arm = {};  ///< with the state of its joints
  bool held = false;
  bool in_contact = false;
  bool sleeps = false;  ///< in the step under way or the last one: it stays at rest, and its engine leaves it out
  // The last step, from which the forces in it can be computed; empty if there is none.
  std::vector<Motion> motions = {};
  std::vector<Touch> touches = {};

  /// The loads on the body, with an impulse of its contacts that is spread evenly over `step_s`.
  Loads loads(const Vector6d& impulse_world, double step_s) const;
  void forget_step();
  /// Keeps what the arm exerted in the stages of the last advanced() with the last of `motions`.
  void record_stages();
  /// The state at the end of a step from `from` under these loads. Its arm goes along from where its step, or part of
  /// one, began.
  BodyState advanced(const BodyState& from, const Loads& all, const WaterField& water, double time_s, double step_s);
  /// Its mass with added mass, without its arm.
  Matrix6d base_mass(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// The inverse of its mass with added mass, and with its arm as it was in the last advanced().
  Matrix6d inverse_mass(const Pose& world_from_body, const WaterField& water, double time_s) const;

  /// Throws InvalidValue, which names step and body, unless `next` is a plausible state for it.
  void require_plausible(const BodyState& next, double time_s, double step_s) const;
};

}  // namespace uwsim
