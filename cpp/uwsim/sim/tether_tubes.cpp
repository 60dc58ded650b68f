#include "uwsim/sim/tether_tubes.h"

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

}  // namespace

TriangleMesh tether_tube(const TetherSpec& spec) { return tube(spec.diameter_m / 2, spec.element_m()); }

void add_tube_poses(const Tether& tether, const RigidBodyWorld& bodies, std::vector<Pose>& poses) {
  const TetherSpec& spec = tether.spec();
  const std::uint64_t own = spec.second.body;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius_m = 0;
  if (own != TetherEnd::kNoBody) {
    middle = bodies.state(own).world_from_body.position_m;
    for (const Eigen::Vector3d& vertex : bodies.spec(own).craft->hull().mesh_body().vertices_m)
      radius_m = std::max(radius_m, vertex.norm());
  }
  const auto along = [](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector3d way = to - from;
    Pose pose;
    pose.position_m = from;
    if (way.norm() > 0) pose.orientation = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), way);
    return pose;
  };
  Pose last = along(tether.position_m(0), tether.position_m(1));
  const std::size_t all = poses.size() + spec.tubes();
  poses.push_back(last);
  for (std::size_t i = 0; i < tether.elements(); ++i) {
    const Eigen::Vector3d &from = tether.position_m(i), &to = tether.position_m(i + 1);
    const bool is_hidden =
        tether.broken() == i || ((from - middle).norm() < radius_m && (to - middle).norm() < radius_m);
    if (!is_hidden) last = i == 0 ? along(to, from) : along(from, to);
    poses.push_back(last);
  }
  poses.resize(all, last);
}

}  // namespace uwsim
