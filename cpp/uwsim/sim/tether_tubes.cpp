#include "uwsim/sim/tether_tubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

constexpr std::uint32_t kSides = 6;

/// A closed tube along z from the origin. Its sides' mean distance from the axis is the radius.
TriangleMesh tube(double radius_m, double length_m) {
  TriangleMesh mesh;
  for (std::uint32_t k = 0; k < kSides; ++k) {
    const double angle = 2 * std::numbers::pi * k / kSides;
    for (const double z : {0.0, length_m})
      mesh.vertices_m.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), z);
  }
  for (std::uint32_t k = 0; k < kSides; ++k) {
    const std::uint32_t next = (k + 1) % kSides;
    mesh.triangles.push_back({2 * k, 2 * next, 2 * k + 1});
    mesh.triangles.push_back({2 * next, 2 * next + 1, 2 * k + 1});
    if (k == 0 || k + 1 == kSides) continue;
    mesh.triangles.push_back({0, 2 * next, 2 * k});
    mesh.triangles.push_back({1, 2 * k + 1, 2 * next + 1});
  }
  return mesh;
}

/// Around a body's hull; of no body, it is empty.
struct Sphere {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius_m = 0;
};

Sphere sphere(const RigidBodyWorld& bodies, std::uint64_t body) {
  Sphere found;
  if (body == TetherEnd::kNoBody) return found;
  found.middle = bodies.state(body).world_from_body.position_m;
  for (const Eigen::Vector3d& vertex : bodies.spec(body).craft->hull().mesh_body().vertices_m)
    found.radius_m = std::max(found.radius_m, vertex.norm());
  return found;
}

}  // namespace

TriangleMesh tether_tube(const TetherSpec& spec) { return tube(spec.diameter_m / 2, spec.element_m()); }

void add_tube_poses(const Tether& tether, const RigidBodyWorld& bodies, std::vector<Pose>& poses) {
  const TetherSpec& spec = tether.spec();
  std::array<Sphere, 2> own;
  for (std::size_t k = 0; k < 2; ++k) own[k] = sphere(bodies, (k == 0 ? spec.first : spec.second).body);
  const auto is_seen = [&](std::size_t i) {
    const Eigen::Vector3d &from = tether.position_m(i), &to = tether.position_m(i + 1);
    return tether.broken() != i && std::ranges::none_of(own, [&](const Sphere& s) {
             return (from - s.middle).norm() < s.radius_m && (to - s.middle).norm() < s.radius_m;
           });
  };
  const auto along = [](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector3d way = to - from;
    Pose pose;
    pose.position_m = from;
    if (way.norm() > 0) pose.orientation = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), way);
    return pose;
  };
  std::size_t first = 0;
  while (first + 1 < tether.elements() && !is_seen(first)) ++first;
  Pose last = along(tether.position_m(first), tether.position_m(first + 1));
  const std::size_t all = poses.size() + spec.tubes();
  poses.push_back(last);
  for (std::size_t i = 0; i < tether.elements(); ++i) {
    const Eigen::Vector3d &from = tether.position_m(i), &to = tether.position_m(i + 1);
    if (is_seen(i)) last = i == 0 ? along(to, from) : along(from, to);
    poses.push_back(last);
  }
  poses.resize(all, last);
}

}  // namespace uwsim
