#include "uwsim/vehicle/hull_pressure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace uwsim {
namespace {

constexpr std::size_t kMaxTriangles = 100'000;
constexpr std::size_t kPatchSize = 32;
constexpr double kFadePerEdge = 0.1;

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Halves edges that are too long. Two triangles that share an edge split it identically, so a closed mesh remains
/// closed.
class EdgeHalver {
 public:
  EdgeHalver(TriangleMesh& mesh, double longest_m) : mesh_(mesh), longest_m_(longest_m) {}

  /// The vertices in the middle of the edges that were halved last.
  const std::map<Edge, std::uint32_t>& middles() const { return middles_; }

  /// Halves every edge longer than the limit once. Returns false if there was none.
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
    // Rotate the corners so that a single long edge comes first, or two long edges come before the short one; then
    // split the remaining quadrilateral.
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

/// A corner of a triangle.
struct Corner {
  const Eigen::Vector3d& arm_m;  // from the body's origin
  double head_m;
  double pressure_pa;
};

Eigen::Vector3d inward_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return -0.5 * (b - a).cross(c - a);
}

/// The load on coplanar triangles, derived from their unit inward area: the integrals of p and of p r.
struct Integrals {
  double pressure = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();

  /// Adds a triangle of signed size `area` over which the pressure is linear: the integral of p is the area times the
  /// mean, and that of p r is area / 12 (sum p sum r + sum p r), with sums over the corners.
  void add(double area, const Eigen::Vector3d& a_m, double a_pa, const Eigen::Vector3d& b_m, double b_pa,
           const Eigen::Vector3d& c_m, double c_pa) {
    const double sum = a_pa + b_pa + c_pa;
    pressure += area / 3 * sum;
    moment += area / 12 * ((sum + a_pa) * a_m + (sum + b_pa) * b_m + (sum + c_pa) * c_m);
  }
};

/// The integrals over the wet part of a triangle of unit area with one or two wet corners, minus those over the whole
/// triangle with zero pressure at dry corners. `odd` is the corner that differs from the other two.
Integrals change_by_cut(const Corner& odd, const Corner& second, const Corner& third) {
  // The points where the pressure vanishes on the two edges from the odd corner, as fractions of the edges' lengths.
  const double s = odd.head_m / (odd.head_m - second.head_m), t = odd.head_m / (odd.head_m - third.head_m);
  const Eigen::Vector3d p = odd.arm_m + s * (second.arm_m - odd.arm_m), q = odd.arm_m + t * (third.arm_m - odd.arm_m);
  Integrals sum;
  sum.add(-1, odd.arm_m, odd.pressure_pa, second.arm_m, second.pressure_pa, third.arm_m, third.pressure_pa);
  if (odd.head_m > 0) {
    sum.add(s * t, odd.arm_m, odd.pressure_pa, p, 0, q, 0);
  } else {
    sum.add(1 - s, p, 0, second.arm_m, second.pressure_pa, third.arm_m, third.pressure_pa);
    sum.add(s * (1 - t), p, 0, third.arm_m, third.pressure_pa, q, 0);
  }
  return sum;
}

/// The working memory of a call, kept so that calls do not allocate. Sizes are multiples of kPressureLanes.
struct Scratch {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<double> heads_m, pressures_pa;
  std::vector<std::uint8_t> wet;

  void resize(std::size_t points) {
    points_m.resize(points);
    heads_m.resize(points);
    pressures_pa.resize(points);
    wet.resize(points);
  }
};

/// Not inlined, so that loops do not look up the thread-local address repeatedly.
[[gnu::noinline]] Scratch& scratch() {
  static thread_local Scratch kept;
  return kept;
}

void find_pressures(const WaterField& water, std::span<const double> heads_m, std::span<double> pressures_pa) {
  const DensityLayer layer = water.density_layer_at(0);
  if (std::isinf(layer.low_m) && layer.gradient_kg_m4 == 0) {
    return pressure_kernels().pressures(heads_m.data(), heads_m.size() / kPressureLanes,
                                        layer.density_kg_m3 * water.gravity(), pressures_pa.data());
  }
  for (std::size_t k = 0; k < heads_m.size(); ++k) {
    pressures_pa[k] = heads_m[k] > 0 ? water.still_pressure_at(-heads_m[k]) : 0;
  }
}

}  // namespace

HullPressure::HullPressure(TriangleMesh mesh_body, double longest_edge_m) : mesh_body_(std::move(mesh_body)) {
  EdgeHalver coarse(mesh_body_, 2 * longest_edge_m), fine(mesh_body_, longest_edge_m);
  while (mesh_body_.triangles.size() < kMaxTriangles && coarse.halve_once()) {
  }
  const std::vector<Triangle> undivided = mesh_body_.triangles;
  if (undivided.size() < kMaxTriangles) fine.halve_once();
  put_vertices();
  gather_patches();
  tabulate_linear();
  std::vector<Middle> middles;
  for (const auto& [ends, middle] : fine.middles()) middles.push_back({middle, {ends.first, ends.second}});
  fade_m_ = kFadePerEdge * longest_edge_m;
  tabulate_quadratic(undivided, std::move(middles));
}

void HullPressure::add_to_table(std::uint32_t vertex, const Vector6d& per_pascal) {
  VertexBlock& block = blocks_[vertex / kPressureLanes];
  for (int i = 0; i < 6; ++i) block.per_pascal[i][vertex % kPressureLanes] += per_pascal(i);
}

void HullPressure::tabulate_linear() {
  inward_areas_m2_.reserve(mesh_body_.triangles.size());
  for (const Triangle& t : mesh_body_.triangles) {
    const Eigen::Vector3d &a = mesh_body_.vertices_m[t[0]], &b = mesh_body_.vertices_m[t[1]],
                          &c = mesh_body_.vertices_m[t[2]];
    const Eigen::Vector3d& inward = inward_areas_m2_.emplace_back(inward_area(a, b, c));
    for (std::size_t k = 0; k < 3; ++k) {
      Integrals one;
      one.add(1, a, k == 0 ? 1 : 0, b, k == 1 ? 1 : 0, c, k == 2 ? 1 : 0);
      Vector6d load;
      load << one.pressure * inward, one.moment.cross(inward);
      add_to_table(t[k], load);
    }
  }
}

/// A pressure that is 1 in the middle of the edge from a to b, and 4 times the product of the barycentric coordinates
/// of a and b elsewhere, has the integral A / 3 over a triangle, and that of p r is A / 15 (2 a + 2 b + c).
void HullPressure::tabulate_quadratic(const std::vector<Triangle>& undivided, std::vector<Middle> middles) {
  std::map<Edge, Middle*> of_edge;
  for (Middle& middle : middles) {
    of_edge[{middle.ends[0], middle.ends[1]}] = &middle;
    for (int i = 0; i < 6; ++i) {
      middle.per_pascal(i) = -blocks_[middle.vertex / kPressureLanes].per_pascal[i][middle.vertex % kPressureLanes];
    }
  }
  for (const Triangle& t : undivided) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t[k], to = t[(k + 1) % 3];
      const auto halved = of_edge.find({std::min(from, to), std::max(from, to)});
      if (halved == of_edge.end()) continue;
      const Eigen::Vector3d &a = mesh_body_.vertices_m[from], &b = mesh_body_.vertices_m[to],
                            &c = mesh_body_.vertices_m[t[(k + 2) % 3]];
      const Eigen::Vector3d inward = inward_area(a, b, c), moment = (2 * a + 2 * b + c) / 15;
      halved->second->per_pascal.head<3>() += inward / 3;
      halved->second->per_pascal.tail<3>() += moment.cross(inward);
    }
  }
  for (const Middle& middle : middles) {
    add_to_table(middle.vertex, middle.per_pascal);
    for (const std::uint32_t end : middle.ends) add_to_table(end, -0.5 * middle.per_pascal);
  }
  middles_ = std::move(middles);
}

void HullPressure::put_vertices() {
  const std::vector<Eigen::Vector3d>& arms = mesh_body_.vertices_m;
  blocks_.assign((arms.size() + kPressureLanes - 1) / kPressureLanes, VertexBlock{});
  for (std::size_t k = 0; k < blocks_.size() * kPressureLanes; ++k) {
    const Eigen::Vector3d& arm = arms[std::min(k, arms.size() - 1)];
    for (int i = 0; i < 3; ++i) blocks_[k / kPressureLanes].arm_m[i][k % kPressureLanes] = arm(i);
  }
}

/// Consecutive triangles in the mesh are usually neighbours and share vertices.
void HullPressure::gather_patches() {
  const std::size_t count = mesh_body_.triangles.size();
  std::vector<std::uint32_t> used;
  for (std::size_t first = 0; first < count; first += kPatchSize) {
    const std::size_t end = std::min(first + kPatchSize, count);
    used.clear();
    for (std::size_t n = first; n < end; ++n)
      used.insert(used.end(), mesh_body_.triangles[n].begin(), mesh_body_.triangles[n].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    patches_.push_back({first, end, patch_vertices_.size(), used.size()});
    patch_vertices_.insert(patch_vertices_.end(), used.begin(), used.end());
  }
}

HullPressure::Load HullPressure::load(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                                      const WaterField& water, double time_s) const {
  const PressureKernels& kernels = pressure_kernels();
  Scratch& at = scratch();
  at.resize(blocks_.size() * kPressureLanes);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = world_from_body;
  kernels.place(blocks_.data(), blocks_.size(), position_world_m.data(), rotation.data(), at.points_m.data()->data());
  water.pressure_heads(at.points_m, time_s, at.heads_m);
  find_pressures(water, at.heads_m, at.pressures_pa);
  Vector6d sum;
  kernels.load(blocks_.data(), blocks_.size(), at.pressures_pa.data(), sum.data());
  kernels.find_wet(at.heads_m.data(), blocks_.size(), at.wet.data());
  for (const Patch& patch : patches_) {
    unsigned wet = 0;
    for (const std::uint32_t vertex : vertices_of(patch)) wet += at.wet[vertex];
    if (wet == 0 || wet == patch.vertex_count) continue;
    for (std::size_t n = patch.first_triangle; n < patch.end_triangle; ++n) {
      const Triangle& t = mesh_body_.triangles[n];
      const bool a = at.wet[t[0]], b = at.wet[t[1]], c = at.wet[t[2]];
      if (a != b || b != c) add_change_by_cut(n, at.heads_m, at.pressures_pa, sum);
    }
  }
  take_back_near_surface(at.heads_m, at.pressures_pa, sum);
  return {sum.head<3>(), sum.tail<3>()};
}

/// A cut is exact for linear pressures only. Hence the quadratic part, which is tabulated for all edges, fades out
/// towards the surface.
void HullPressure::take_back_near_surface(std::span<const double> heads_m, std::span<const double> pressures_pa,
                                          Vector6d& load) const {
  for (const Middle& middle : middles_) {
    const std::uint32_t a = middle.ends[0], b = middle.ends[1], m = middle.vertex;
    const double least_m = std::min({heads_m[a], heads_m[b], heads_m[m]});
    if (least_m >= fade_m_) continue;
    const double surplus_pa = pressures_pa[m] - 0.5 * (pressures_pa[a] + pressures_pa[b]);
    load -= (1 - std::max(0.0, least_m) / fade_m_) * surplus_pa * middle.per_pascal;
  }
}

void HullPressure::add_change_by_cut(std::size_t triangle, std::span<const double> heads_m,
                                     std::span<const double> pressures_pa, Vector6d& load) const {
  const Triangle& t = mesh_body_.triangles[triangle];
  const auto is_wet = [&](std::size_t k) { return heads_m[t[k]] > 0; };
  const auto corner = [&](std::size_t k) {
    return Corner{mesh_body_.vertices_m[t[k]], heads_m[t[k]], pressures_pa[t[k]]};
  };
  const std::size_t odd = is_wet(1) == is_wet(2) ? 0 : is_wet(0) == is_wet(2) ? 1 : 2;
  const Integrals change = change_by_cut(corner(odd), corner((odd + 1) % 3), corner((odd + 2) % 3));
  load.head<3>() += change.pressure * inward_areas_m2_[triangle];
  load.tail<3>() += change.moment.cross(inward_areas_m2_[triangle]);
}

}  // namespace uwsim
