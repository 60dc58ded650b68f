#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/world/swarm.h"
#include "uwsim/world/world.h"

namespace uwsim {

class RayScene;

/// Rays from one point, within an angle of an axis and up to a distance.
struct RayCone {
  Eigen::Vector3d apex_world_m;
  Eigen::Vector3d axis_world;  ///< unit
  double cosine;               ///< of the angle
  double length_m;
};

/// Bodies that move among the fixed surfaces of a world, such as vehicles, as targets for rays. The surface of each
/// body is prepared once, in the body's frame, as a separate RayScene; a pose places it. Rays are transformed into the
/// body's frame in double, so hits are as exact as those on the world (rays/README.md). A cast examines a body only if
/// a sphere around it is within reach, and does not allocate, except where it is the first to reach a school. Must not
/// be used while a body is being placed; copies are independent and share the surfaces.
class MovingBodies {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  /// `first_label`: the label of the first body; the labels of the other bodies follow consecutively, then those of the
  /// schools of fish. A fish is a body of its own for rays and is never hidden.
  explicit MovingBodies(Label first_label, std::span<const std::shared_ptr<const Swarm>> schools = {});

  /// Adds a body and returns its index. Throws InvalidValue for a mesh that is not well formed.
  std::size_t add(const TriangleMesh& surface_body_m);
  void place(std::size_t body, const Pose& world_from_body);
  /// Places the fish of all schools; only where rays come near are their places computed.
  void place_schools(double time_s);
  bool has_schools() const { return !schools_.empty(); }
  /// The number of bodies, without fish.
  std::size_t size() const { return bodies_.size(); }
  /// Bodies added from now on have labels after those of the schools.
  void add_after_schools() { before_schools_ = std::min(before_schools_, bodies_.size()); }
  Label label(std::size_t body) const {
    return static_cast<Label>(first_label_ + body + (body < before_schools_ ? 0 : schools_.size()));
  }
  /// The rotation of the body with a label; the identity for fish.
  Eigen::Matrix3f turn_of(Label body_label) const;
  /// A point in the frame of the body with a label; fish have the world's.
  Eigen::Vector3d on_body(Label body_label, const Eigen::Vector3d& point_world_m) const;
  Label school_label(std::size_t school) const {
    return static_cast<Label>(first_label_ + std::min(before_schools_, bodies_.size()) + school);
  }

  // The following functions exclude the body `hidden`.

  /// Replaces each hit by a hit on a body if that is nearer.
  void cast(std::span<const ExactRays> rays, std::size_t hidden, std::span<ExactHits> hits) const;
  /// The same in float, like the version of RayScene::cast for pictures.
  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order, std::size_t hidden,
            HitPacket& hits) const;
  /// Marks the lanes that a body blocks.
  void occlude(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order, std::size_t hidden,
               Blocked& blocked) const;
  /// Whether any of the cone's rays may hit a body; conservative.
  bool may_be_in(const RayCone& cone, std::size_t hidden) const;
  /// The smaller of `nearest_m` and the distance to the nearest triangle.
  double distance(const Eigen::Vector3d& point_world_m, double nearest_m, std::size_t hidden) const;

 private:
  struct Body {
    std::shared_ptr<const RayScene> surface;
    Eigen::Vector3d centre_body_m;  // centre of a sphere around it
    double radius_m;                // with a margin for rounding
    Eigen::Vector3d centre_world_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d position_world_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d body_from_world = Eigen::Matrix3d::Identity();  // rotation
  };
  struct Group {  // of neighbouring fish, in a sphere
    Eigen::Vector3d centre_world_m;
    double radius_m;
  };
  struct Shoal {
    std::vector<Swimmer> fish;
    std::vector<Group> groups;
  };
  struct PlacedSchool;  // at one time; immutable, and therefore shared by copies
  struct SwimmingSchool {
    std::shared_ptr<const Swarm> school;
    std::vector<std::vector<Body>> shapes;  // by size and phase, without a place
    double reach_m, radius_m;               // of the school, and of its largest fish about its origin
    explicit SwimmingSchool(std::shared_ptr<const Swarm> swims);
    Shoal at(double time_s) const;
    Body placed(const Swimmer& fish) const;
  };

  const Body* body_of(Label body_label) const;
  static Body prepared(const TriangleMesh& surface_body_m);
  static void cast_at(const Body& body, Label label, const ExactRays& rays, ExactHits& hits);
  static void cast_at(const Body& body, Label label, const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                      RayOrder order, std::uint32_t piece, HitPacket& hits);
  bool has_targets(std::size_t hidden) const {
    return bodies_.size() > (hidden < bodies_.size() ? 1u : 0u) || !schools_.empty();
  }
  template <typename Reaches, typename Hits, typename Visit>
  void for_each_reached(std::size_t hidden, const Reaches& may_reach, const Hits& may_hit, Visit&& visit) const;

  Label first_label_;
  std::size_t before_schools_ = kNone;
  std::vector<Body> bodies_;
  std::vector<std::shared_ptr<const SwimmingSchool>> schools_;
  std::vector<std::shared_ptr<const PlacedSchool>> placed_;  // of each school
};

}  // namespace uwsim
