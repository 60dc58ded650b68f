#include "uwsim/vehicle/hull_pressure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace uwsim {
namespace {

constexpr std::size_t kMaxTriangles = 100'000;

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Halves edges that are too long. Two triangles that share an edge split it alike, so a closed mesh stays closed.
class EdgeHalver {
 public:
  EdgeHalver(TriangleMesh& mesh, double longest_m) : mesh_(mesh), longest_m_(longest_m) {}

  /// Halves every edge longer than the limit once. Returns false when there was none.
  bool halve_once() {
    std::vector<Triangle> out;
    middles_.clear();
    for (const Triangle& t : mesh_.triangles) split(t, out);
    mesh_.triangles = std::move(out);
    return !middles_.empty();
  }

 private:
  bool too_long(std::uint32_t a, std::uint32_t b) const {
    return (mesh_.vertices_m[a] - mesh_.vertices_m[b]).norm() > longest_m_;
  }
  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] =
        middles_.try_emplace(Edge(std::min(a, b), std::max(a, b)), static_cast<std::uint32_t>(mesh_.vertices_m.size()));
    if (is_new) mesh_.vertices_m.emplace_back(0.5 * (mesh_.vertices_m[a] + mesh_.vertices_m[b]));
    return at->second;
  }
  void split(Triangle t, std::vector<Triangle>& out) {
    const int long_edges = too_long(t[0], t[1]) + too_long(t[1], t[2]) + too_long(t[2], t[0]);
    if (long_edges == 0) return out.push_back(t);
    if (long_edges == 3) {
      const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
      out.insert(out.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
      return;
    }
    // Rotate the corners so that one long edge comes first, or of two long ones both come before the short one; then
    // cut the quadrangle that is left.
    while (!too_long(t[0], t[1]) || (long_edges == 2 && too_long(t[2], t[0]))) t = {t[1], t[2], t[0]};
    const std::uint32_t ab = middle(t[0], t[1]);
    if (long_edges == 1) return void(out.insert(out.end(), {{t[0], ab, t[2]}, {ab, t[1], t[2]}}));
    const std::uint32_t bc = middle(t[1], t[2]);
    out.insert(out.end(), {{ab, t[1], bc}, {t[0], ab, bc}, {t[0], bc, t[2]}});
  }

  TriangleMesh& mesh_;
  double longest_m_;
  std::map<Edge, std::uint32_t> middles_;
};

/// A point of the surface.
struct Node {
  const Eigen::Vector3d& arm_m;  // from the body's origin
  double head_m;
  double pressure_pa;
};

Eigen::Vector3d inward_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return -0.5 * (b - a).cross(c - a);
}

/// Adds `sign` times the load on a triangle of area A over which the pressure p is linear: the integral of p is A times
/// its mean, that of p r is A / 12 (sum p sum r + sum p r), sums over the corners.
void add_load(HullPressure::Load& load, const Node& a, const Node& b, const Node& c, double sign = 1) {
  const Eigen::Vector3d inward = sign * inward_area(a.arm_m, b.arm_m, c.arm_m);
  const double sum = a.pressure_pa + b.pressure_pa + c.pressure_pa;
  load.force_body_n += sum / 3 * inward;
  const Eigen::Vector3d weighted =
      (sum + a.pressure_pa) * a.arm_m + (sum + b.pressure_pa) * b.arm_m + (sum + c.pressure_pa) * c.arm_m;
  load.moment_body_nm += (weighted / 12).cross(inward);
}

/// Where the edge between a wet and a dry corner has no pressure.
Eigen::Vector3d cut_point(const Node& wet, const Node& dry) {
  return wet.arm_m + wet.head_m / (wet.head_m - dry.head_m) * (dry.arm_m - wet.arm_m);
}

/// Adds the load on the wet part of a triangle with one or two wet corners. `odd` is the one that differs from the
/// others.
void add_load_of_cut(HullPressure::Load& load, const Node& odd, const Node& second, const Node& third) {
  if (odd.head_m > 0) {
    const Eigen::Vector3d p = cut_point(odd, second), q = cut_point(odd, third);
    return add_load(load, odd, {p, 0, 0}, {q, 0, 0});
  }
  const Eigen::Vector3d p = cut_point(second, odd), q = cut_point(third, odd);
  add_load(load, {p, 0, 0}, second, third);
  add_load(load, {p, 0, 0}, third, {q, 0, 0});
}

}  // namespace

HullPressure::HullPressure(TriangleMesh mesh_body, double longest_edge_m) : mesh_body_(std::move(mesh_body)) {
  EdgeHalver halver(mesh_body_, longest_edge_m);
  while (mesh_body_.triangles.size() < kMaxTriangles && halver.halve_once()) {
  }
  per_pascal_.resize(mesh_body_.vertices_m.size());
  for (const Triangle& t : mesh_body_.triangles) {
    const std::array<const Eigen::Vector3d*, 3> r = {&mesh_body_.vertices_m[t[0]], &mesh_body_.vertices_m[t[1]],
                                                     &mesh_body_.vertices_m[t[2]]};
    for (std::size_t k = 0; k < 3; ++k) {
      add_load(per_pascal_[t[k]], {*r[0], 0, k == 0 ? 1.0 : 0.0}, {*r[1], 0, k == 1 ? 1.0 : 0.0},
               {*r[2], 0, k == 2 ? 1.0 : 0.0});
    }
  }
}

HullPressure::Load HullPressure::load(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                                      const WaterField& water, double time_s) const {
  static thread_local std::vector<Eigen::Vector3d> points;
  static thread_local std::vector<double> heads, pressures;
  const std::vector<Eigen::Vector3d>& arms = mesh_body_.vertices_m;
  points.resize(arms.size());
  heads.resize(arms.size());
  pressures.resize(arms.size());
  for (std::size_t k = 0; k < arms.size(); ++k) points[k] = position_world_m + world_from_body * arms[k];
  water.pressure_heads(points, time_s, heads);
  Load sum;
  for (std::size_t k = 0; k < arms.size(); ++k) {
    pressures[k] = heads[k] > 0 ? water.still_pressure_at(-heads[k]) : 0;
    sum.force_body_n += pressures[k] * per_pascal_[k].force_body_n;
    sum.moment_body_nm += pressures[k] * per_pascal_[k].moment_body_nm;
  }
  for (const Triangle& t : mesh_body_.triangles) {
    const bool a = heads[t[0]] > 0, b = heads[t[1]] > 0, c = heads[t[2]] > 0;
    if (a == b && b == c) continue;
    const auto node = [&](std::size_t k) { return Node{arms[t[k]], heads[t[k]], pressures[t[k]]}; };
    const std::size_t odd = b == c ? 0 : a == c ? 1 : 2;
    const Node first = node(odd), second = node((odd + 1) % 3), third = node((odd + 2) % 3);
    add_load(sum, first, second, third, -1);  // take back the tabulated load, which is over all of it
    add_load_of_cut(sum, first, second, third);
  }
  return sum;
}

}  // namespace uwsim
