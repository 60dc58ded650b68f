#include "uwsim/dynamics/contact_finder.h"

#include <algorithm>
#include <utility>

#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/contact_shapes.h"
#include "uwsim/dynamics/surface_contact.h"
#include "uwsim/dynamics/terrain_patch.h"

namespace uwsim {
namespace {

// Contacts closer together than this, with similar normals, are merged.
constexpr double kSamePlace_m = 0.01;
constexpr double kSameNormal = 0.99;  // cosine
// Of two merged contacts, the deeper one is kept if the difference exceeds this rounding error.
constexpr double kDeeper_m = 1e-9;
constexpr std::size_t kReservedTriangles = 4096;  // of the terrain near one body; a step that needs more allocates

/// Encloses all that a body may touch in a step.
struct Sphere {
  Eigen::Vector3d middle_m;
  double radius_m;

  bool meets(const Sphere& other) const {
    const double near_m = radius_m + other.radius_m;
    return (middle_m - other.middle_m).squaredNorm() < near_m * near_m;
  }
};

}  // namespace

struct ContactFinder::Impl {
  std::shared_ptr<const FixedSurfaces> fixed;
  ConvexContact convex_contact;
  SurfaceContact surface_contact;
  ContactBudget budget;
  std::vector<std::shared_ptr<const ConvexBody>> bodies;
  // Kept so that a step does not allocate.
  SolidTriangles::Stack solids_stack;
  SurfacePatch terrain_patch;
  std::vector<SurfacePatch> solid_patches;
  std::vector<Sphere> spheres;  // of the moving bodies, side by side, since most pairs are far apart
  std::vector<Contact>* contacts = nullptr;
  std::size_t first_of_pair = 0;

  explicit Impl(const World& source) : fixed(fixed_surfaces(source)) { terrain_patch.reserve(kReservedTriangles); }

  void find(std::span<const MovingBody> moving, std::vector<Contact>& out) {
    contacts = &out;
    contacts->clear();
    spheres.clear();
    for (std::size_t a = 0; a < moving.size(); ++a) {
      spheres.push_back({moving[a].world_from_body.position_m, bodies[a]->radius_m + moving[a].reach_m});
      if (!moving[a].collides || bodies[a]->pieces.empty()) continue;
      budget.begin(a, 2 * bodies[a]->box.half_size_body_m);
      if (moving[a].meets_world) find_with_world(static_cast<int>(a), *bodies[a], moving[a]);
      for (std::size_t b = 0; b < a; ++b) {
        if (!spheres[a].meets(spheres[b]) || !moving[b].collides || bodies[b]->pieces.empty()) continue;
        if (moving[a].owner == moving[b].owner || !(moving[a].meets_world || moving[b].meets_world)) continue;
        find_between(a, moving[a], b, moving[b]);
      }
    }
  }

  void find_with_world(int a, const ConvexBody& body, const MovingBody& moving) {
    const Pose& pose = moving.world_from_body;
    const Eigen::Matrix3d rotation = pose.rotation();
    const double reach_m = moving.reach_m + kRestGap_m;
    const WorldBox whole = body.box.in_world(pose.position_m, rotation, reach_m);
    if (!fixed->may_touch(whole.low_m, whole.high_m)) return;
    first_of_pair = contacts->size();
    terrain_patch.clear();
    if (const auto& terrain = fixed->world.terrain())
      add_terrain(*terrain, whole.low_m, whole.high_m, terrain_patch, budget);
    const std::size_t solid_count = fixed->find(whole.low_m, whole.high_m, solids_stack, solid_patches, budget);
    if (terrain_patch.triangles.empty() && solid_count == 0) return;
    for (const ConvexBody::Piece& piece : body.pieces) {
      const WorldBox box = piece.box.in_world(pose.position_m, rotation, reach_m);
      const PlacedShape placed{piece.shape, pose,       rotation, piece.box.middle_body_m, piece.box.half_size_body_m,
                               box.low_m,   box.high_m, reach_m};
      add_all(a, surface_contact.find(placed, terrain_patch, SurfaceContact::Under::kSolid, budget));
      for (std::size_t k = 0; k < solid_count; ++k)
        add_all(a, surface_contact.find(placed, solid_patches[k], SurfaceContact::Under::kClosed, budget));
    }
  }

  void add_all(int a, std::span<const ContactPoint> found) {
    for (const ContactPoint& point : found) add(a, kFixedBody, point);
  }

  void find_between(std::size_t a, const MovingBody& body_a, std::size_t b, const MovingBody& body_b) {
    first_of_pair = contacts->size();
    const Pose &pose_a = body_a.world_from_body, &pose_b = body_b.world_from_body;
    const Eigen::Matrix3d rotation_a = pose_a.rotation(), rotation_b = pose_b.rotation();
    const double reach_m = body_a.reach_m + body_b.reach_m + kRestGap_m;
    for (const ConvexBody::Piece& piece_a : bodies[a]->pieces) {
      const WorldBox box_a = piece_a.box.in_world(pose_a.position_m, rotation_a, reach_m);
      for (const ConvexBody::Piece& piece_b : bodies[b]->pieces) {
        if (!box_a.meets(piece_b.box.in_world(pose_b.position_m, rotation_b, 0))) continue;
        budget.spend(ContactBudget::kTestsPerOverlap);
        for (const ContactPoint& found :
             convex_contact.with_shape(piece_a.shape, pose_a, piece_b.shape, pose_b, reach_m))
          add(static_cast<int>(a), static_cast<int>(b), found);
      }
    }
  }

  /// Adds a contact. Of several contacts between the same two bodies at the same place, only the deepest is kept.
  void add(int a, int b, const ContactPoint& found) {
    const double gap_m = found.distance_m - kRestGap_m;
    const auto same = [&](const Contact& known) {
      return (known.point_world_m - found.point_world_m).squaredNorm() <= kSamePlace_m * kSamePlace_m &&
             known.normal_world.dot(found.normal_world) >= kSameNormal;
    };
    const auto first = contacts->begin() + static_cast<std::ptrdiff_t>(first_of_pair);
    budget.spend(contacts->size() - first_of_pair);
    const auto known = std::find_if(first, contacts->end(), same);
    if (known != contacts->end() && gap_m >= known->gap_m - kDeeper_m) return;
    Contact& contact = known != contacts->end() ? *known : contacts->emplace_back();
    contact.a = a;
    contact.b = b;
    contact.point_world_m = found.point_world_m;
    contact.normal_world = found.normal_world;
    contact.gap_m = gap_m;
  }
};

ContactFinder::ContactFinder(const World& world) : impl_(std::make_unique<Impl>(world)) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

void ContactFinder::add_body(std::span<const ConvexPiece> pieces_body_m, const std::optional<RoundPiece>& round) {
  impl_->bodies.push_back(convex_body(pieces_body_m, round));
}

void ContactFinder::set_body(std::size_t body, std::span<const ConvexPiece> pieces_body_m,
                             const std::optional<RoundPiece>& round) {
  impl_->bodies.at(body) = convex_body(pieces_body_m, round);
}

double ContactFinder::radius_m(std::size_t body) const { return impl_->bodies.at(body)->radius_m; }

double ContactFinder::thickness_m(std::size_t body) const {
  return 2 * impl_->bodies.at(body)->box.half_size_body_m.minCoeff();
}

bool ContactFinder::may_touch_world(const Eigen::Vector3d& centre_world_m, double radius_m) const {
  const Eigen::Array3d out = Eigen::Array3d::Constant(radius_m + kRestGap_m);
  return impl_->fixed->may_touch(centre_world_m.array() - out, centre_world_m.array() + out);
}

void ContactFinder::find(std::span<const MovingBody> bodies, std::vector<Contact>& contacts) {
  impl_->find(bodies, contacts);
}

}  // namespace uwsim
