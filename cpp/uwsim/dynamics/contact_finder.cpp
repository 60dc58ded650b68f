#include "uwsim/dynamics/contact_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "uwsim/dynamics/broad_phase.h"
#include "uwsim/dynamics/convex_contact.h"
#include "uwsim/dynamics/solid_triangles.h"

namespace uwsim {
namespace {

constexpr double kSamePlace_m = 0.01;             // contacts closer together than this, with normals alike, are merged
constexpr double kSameNormal = 0.99;              // cosine
constexpr std::size_t kReservedTriangles = 4096;  // near one piece; with more, a step allocates
// Least cosine between an overlap's normal and the terrain's; deeper overlaps are found by the shape's corners.
constexpr double kFacesUp = 0.3;

struct Box {
  Eigen::Vector3d low_m, high_m;
  bool meets(const Box& other) const {
    return (low_m.array() <= other.high_m.array()).all() && (other.low_m.array() <= high_m.array()).all();
  }
};

/// A box along the body's axes.
struct BodyBox {
  Eigen::Vector3d middle_body_m, half_size_body_m;

  static BodyBox around(const ConvexPiece& points_m) {
    Eigen::Vector3d low = points_m.front(), high = low;
    for (const Eigen::Vector3d& p : points_m) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    return {0.5 * (low + high), 0.5 * (high - low)};
  }
  /// Its bounding box along the world's axes, enlarged by `reach_m`.
  Box in_world(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& rotation, double reach_m) const {
    const Eigen::Vector3d middle = position_m + rotation * middle_body_m;
    const Eigen::Vector3d half = rotation.cwiseAbs() * half_size_body_m + Eigen::Vector3d::Constant(reach_m);
    return {middle - half, middle + half};
  }
};

struct Piece {
  ConvexShape shape;
  BodyBox box;
};

struct Body {
  std::vector<Piece> pieces;
  BodyBox box;
  double radius_m = 0;
};

}  // namespace

struct ContactFinder::Impl {
  World world;
  BroadPhase broad_phase;
  SolidTriangles solids;
  ConvexContact convex_contact;
  std::vector<Body> bodies;
  std::vector<SolidTriangles::Index> near;  // kept so that steps allocate nothing
  std::vector<Contact>* contacts = nullptr;
  std::size_t first_of_pair = 0;

  explicit Impl(const World& source) : world(source), broad_phase(source), solids(source) {
    near.reserve(kReservedTriangles);
  }

  void find(std::span<const MovingBody> moving, std::vector<Contact>& out) {
    contacts = &out;
    contacts->clear();
    for (std::size_t a = 0; a < moving.size(); ++a) {
      if (!moving[a].collides) continue;
      find_with_world(static_cast<int>(a), bodies[a], moving[a]);
      for (std::size_t b = 0; b < a; ++b) {
        if (!moving[b].collides) continue;
        const double near_m = bodies[a].radius_m + bodies[b].radius_m + moving[a].reach_m + moving[b].reach_m;
        const Eigen::Vector3d between = moving[a].world_from_body.position_m - moving[b].world_from_body.position_m;
        if (between.squaredNorm() < near_m * near_m) find_between(a, moving[a], b, moving[b]);
      }
    }
  }

  void find_with_world(int a, const Body& body, const MovingBody& moving) {
    const Pose& pose = moving.world_from_body;
    const Eigen::Matrix3d rotation = pose.rotation();
    const double reach_m = moving.reach_m + kRestGap_m;
    const Box whole = body.box.in_world(pose.position_m, rotation, reach_m);
    if (!broad_phase.may_touch(whole.low_m, whole.high_m)) return;
    first_of_pair = contacts->size();
    for (const Piece& piece : body.pieces) {
      const Box box = piece.box.in_world(pose.position_m, rotation, reach_m);
      if (!broad_phase.may_touch(box.low_m, box.high_m)) continue;
      if (world.terrain()) find_with_terrain(a, piece.shape, pose, box, reach_m);
      find_with_solids(a, piece.shape, pose, box, reach_m);
    }
  }

  void find_with_terrain(int a, const ConvexShape& shape, const Pose& pose, const Box& box, double reach_m) {
    const Heightfield& terrain = *world.terrain();
    const auto cell = [&](double along_m, std::size_t nodes) {
      return static_cast<std::size_t>(
          std::clamp(std::floor(along_m / terrain.spacing_m()), 0.0, static_cast<double>(nodes - 2)));
    };
    const Eigen::Vector2d low = box.low_m.head<2>() - terrain.origin_m();
    const Eigen::Vector2d high = box.high_m.head<2>() - terrain.origin_m();
    bool reaches = false;
    for (std::size_t j = cell(low.y(), terrain.ny()); j <= cell(high.y(), terrain.ny()); ++j) {
      for (std::size_t i = cell(low.x(), terrain.nx()); i <= cell(high.x(), terrain.nx()); ++i) {
        const float* corner = terrain.heights_m().data() + j * terrain.nx() + i;
        const auto [lowest, highest] =
            std::minmax({corner[0], corner[1], corner[terrain.nx()], corner[terrain.nx() + 1]});
        if (highest < box.low_m.z()) continue;
        reaches = true;
        if (lowest > box.high_m.z()) continue;
        for (std::size_t half = 0; half < 2; ++half) {
          const auto [u, v, w] = terrain.triangle(2 * (j * (terrain.nx() - 1) + i) + half);
          find_with_terrain_triangle(a, shape, pose, {terrain.vertex(u), terrain.vertex(v), terrain.vertex(w)},
                                     reach_m);
        }
      }
    }
    if (reaches) add_corners_under_terrain(a, shape, pose);
  }

  void find_with_terrain_triangle(int a, const ConvexShape& shape, const Pose& pose,
                                  const std::array<Eigen::Vector3d, 3>& triangle, double reach_m) {
    const Eigen::Vector3d up = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
    for (const ContactPoint& found : convex_contact.with_triangle(shape, pose, triangle, reach_m)) {
      const bool overlaps = found.distance_m <= 0;
      if (found.normal_world.dot(up) < (overlaps ? kFacesUp : 0.0)) continue;
      if (overlaps || terrain_is_nearest(found)) add(a, kFixedBody, found);
    }
  }

  /// The terrain's counterpart of InternalEdges::is_nearest: from the point towards the body, the terrain must fall
  /// away at least as steeply as the plane perpendicular to the normal.
  bool terrain_is_nearest(const ContactPoint& found) const {
    const Eigen::Vector2d aside = found.normal_world.head<2>();
    const double lean = aside.norm();
    if (lean < 1e-6) return true;
    const double step_m = 0.02 * world.terrain()->spacing_m();
    const Eigen::Vector2d there = found.point_world_m.head<2>() + step_m / lean * aside;
    const double height_m = world.terrain()->height_at(there.x(), there.y());
    if (std::isnan(height_m)) return true;
    return lean + found.normal_world.z() * (height_m - found.point_world_m.z()) / step_m < 1e-3;
  }

  /// Corners under the terrain are contacts, however deep they are.
  void add_corners_under_terrain(int a, const ConvexShape& shape, const Pose& pose) {
    const Heightfield& terrain = *world.terrain();
    const double d = 0.01 * terrain.spacing_m();
    for (const Eigen::Vector3d& corner : shape.corners_body_m()) {
      const Eigen::Vector3d p = pose.point(corner);
      const double height_m = terrain.height_at(p.x(), p.y());
      if (!(p.z() < height_m)) continue;
      const double east = terrain.height_at(p.x() + d, p.y()), north = terrain.height_at(p.x(), p.y() + d);
      const Eigen::Vector3d normal = std::isnan(east + north)
                                         ? Eigen::Vector3d::UnitZ()
                                         : Eigen::Vector3d(height_m - east, height_m - north, d).normalized();
      add(a, kFixedBody, {p, normal, (p.z() - height_m) * normal.z()});
    }
  }

  void find_with_solids(int a, const ConvexShape& shape, const Pose& pose, const Box& box, double reach_m) {
    solids.find(box.low_m, box.high_m, near);
    for (const SolidTriangles::Index& index : near) {
      const InternalEdges& edges = solids.edges(index);
      for (const ContactPoint& found :
           convex_contact.with_triangle(shape, pose, solids.corners_world_m(index), reach_m)) {
        if (found.distance_m <= 0 || edges.is_nearest(index.triangle, found.point_world_m, found.normal_world))
          add(a, kFixedBody, found);
      }
    }
  }

  void find_between(std::size_t a, const MovingBody& body_a, std::size_t b, const MovingBody& body_b) {
    first_of_pair = contacts->size();
    const Pose &pose_a = body_a.world_from_body, &pose_b = body_b.world_from_body;
    const Eigen::Matrix3d rotation_a = pose_a.rotation(), rotation_b = pose_b.rotation();
    const double reach_m = body_a.reach_m + body_b.reach_m + kRestGap_m;
    for (const Piece& piece_a : bodies[a].pieces) {
      const Box box_a = piece_a.box.in_world(pose_a.position_m, rotation_a, reach_m);
      for (const Piece& piece_b : bodies[b].pieces) {
        if (!box_a.meets(piece_b.box.in_world(pose_b.position_m, rotation_b, 0))) continue;
        for (const ContactPoint& found :
             convex_contact.with_shape(piece_a.shape, pose_a, piece_b.shape, pose_b, reach_m))
          add(static_cast<int>(a), static_cast<int>(b), found);
      }
    }
  }

  /// Adds a contact. Of several of one pair of bodies at one place, the deepest is kept.
  void add(int a, int b, const ContactPoint& found) {
    const double gap_m = found.distance_m - kRestGap_m;
    const auto same = [&](const Contact& known) {
      return (known.point_world_m - found.point_world_m).squaredNorm() <= kSamePlace_m * kSamePlace_m &&
             known.normal_world.dot(found.normal_world) >= kSameNormal;
    };
    const auto first = contacts->begin() + static_cast<std::ptrdiff_t>(first_of_pair);
    const auto known = std::find_if(first, contacts->end(), same);
    if (known != contacts->end() && gap_m >= known->gap_m) return;
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

void ContactFinder::add_body(std::span<const ConvexPiece> pieces_body_m) {
  Body body;
  ConvexPiece all;
  for (const ConvexPiece& points : pieces_body_m) {
    ConvexShape shape(points);
    const BodyBox box = BodyBox::around(shape.corners_body_m());
    all.insert(all.end(), shape.corners_body_m().begin(), shape.corners_body_m().end());
    body.pieces.push_back({std::move(shape), box});
  }
  body.box = BodyBox::around(all);
  for (const Eigen::Vector3d& corner : all) body.radius_m = std::max(body.radius_m, corner.norm());
  impl_->bodies.push_back(std::move(body));
}

double ContactFinder::radius_m(std::size_t body) const { return impl_->bodies.at(body).radius_m; }

void ContactFinder::find(std::span<const MovingBody> bodies, std::vector<Contact>& contacts) {
  impl_->find(bodies, contacts);
}

}  // namespace uwsim
