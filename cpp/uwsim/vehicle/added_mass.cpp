#include "uwsim/vehicle/added_mass.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/vehicle/panel.h"

namespace uwsim {
namespace {

constexpr double kFar = 2.5;   // distance over the sum of two panels' radii from which points replace panels
constexpr double kNear = 1.0;  // ... up to which the points of a panel are dense
constexpr std::size_t kRowsAtOnce = 64;
constexpr std::size_t kMostPanels = 10000;  // with half as many vertices: 200 MB

/// The normal velocity at a point of a panel, for each unit motion.
Vector6d speeds(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal) {
  Vector6d all;
  all << normal, point_m.cross(normal);
  return all;
}

/// Barycentric coordinates of Panel's points in each of the triangles that result from halving the edges `times` times.
std::vector<Eigen::Vector3d> points_of_halved(int times) {
  std::vector<Eigen::Matrix3d> parts{Eigen::Matrix3d::Identity()};  // a corner in each column
  for (int k = 0; k < times; ++k) {
    std::vector<Eigen::Matrix3d> smaller;
    for (const Eigen::Matrix3d& part : parts) {
      const Eigen::Vector3d a = part.col(0), b = part.col(1), c = part.col(2);
      const Eigen::Vector3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
      for (const auto& [p, q, r] :
           {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}}) {
        smaller.emplace_back() << p, q, r;
      }
    }
    parts = std::move(smaller);
  }
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Matrix3d& part : parts) {
    for (int k = 0; k < 3; ++k)
      points.push_back(part * (Eigen::Vector3d::Constant(1.0 / 6) + 0.5 * Eigen::Vector3d::Unit(k)));
  }
  return points;
}

/// The influence of all panels on the points of one, integrated over it.
struct Row {
  /// For each vertex: the integral of its surface curl / r (3), and of its dipoles times the panel's three hats (3).
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> of_vertex;
  /// The integral of sources of the strength of the normal velocities / r, times the panel's three hats.
  Eigen::Matrix<double, 3, 6> of_speeds;
};

class Operators {
 public:
  explicit Operators(const TriangleMesh& mesh) : mesh_(mesh) {
    for (const Triangle& t : mesh.triangles) {
      const Panel panel({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
      if (panel.area_m2() <= 0) continue;
      panels_.push_back(panel);
      corners_.push_back(t);
    }
  }

  Matrix6d added_mass(int threads) const {
    const auto vertices = static_cast<Eigen::Index>(mesh_.vertices_m.size());
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(vertices, vertices);  // 4 pi W
    Eigen::Matrix<double, Eigen::Dynamic, 6> right = Eigen::Matrix<double, Eigen::Dynamic, 6>::Zero(vertices, 6);
    Matrix6d mass = Matrix6d::Zero();
    std::vector<Row> rows(kRowsAtOnce);
    for (std::size_t start = 0; start < panels_.size(); start += kRowsAtOnce) {
      const std::size_t count = std::min(kRowsAtOnce, panels_.size() - start);
      parallel_batches(count, 1, threads,
                       [&](std::size_t first, std::size_t, std::size_t) { find(start + first, rows[first]); });
      for (std::size_t k = 0; k < count; ++k) {
        const Panel& panel = panels_[start + k];
        const Triangle& own = corners_[start + k];
        Eigen::Matrix<double, 3, 6> speeds_at;
        for (int c = 0; c < 3; ++c) {
          speeds_at.row(c) = speeds(panel.corner_m(c), panel.normal()).transpose();
          stiffness.col(own[c]).noalias() +=
              rows[k].of_vertex.leftCols<3>() * (panel.facing_m(c) / (2 * panel.area_m2()));
        }
        right.noalias() += rows[k].of_vertex.rightCols<3>() * speeds_at;
        mass += speeds_at.transpose() * rows[k].of_speeds;
        for (int c = 0; c < 3; ++c) {
          right.row(own[c]) +=
              2 * std::numbers::pi * panel.area_m2() / 12 * (speeds_at.colwise().sum() + speeds_at.row(c));
        }
      }
    }
    make_positive(stiffness);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(stiffness);
    require(factors.info() == Eigen::Success, "mesh.triangles", panels_.size(), "must be no slivers");
    mass += right.transpose() * factors.solve(right);
    return 0.5 * (mass + mass.transpose()) / (4 * std::numbers::pi);
  }

 private:
  /// Makes the lower triangle of W that of a symmetric matrix, which quadrature leaves it almost; and of a positive
  /// one: a potential that is constant on a closed part moves no water, so any constant will do.
  void make_positive(Eigen::MatrixXd& stiffness) const {
    const std::vector<std::uint32_t> part = parts();
    std::vector<double> members(part.size(), 0);
    for (const std::uint32_t root : part) ++members[root];
    const double size = stiffness.trace() / static_cast<double>(stiffness.rows());
    for (std::uint32_t l = 0; l < part.size(); ++l) {
      for (std::uint32_t k = l; k < part.size(); ++k) {
        stiffness(k, l) =
            0.5 * (stiffness(k, l) + stiffness(l, k)) + (part[k] == part[l] ? size / members[part[l]] : 0);
      }
    }
  }

  /// One vertex of the connected part to which each vertex belongs.
  std::vector<std::uint32_t> parts() const {
    std::vector<std::uint32_t> part(mesh_.vertices_m.size());
    std::iota(part.begin(), part.end(), 0u);
    const auto root = [&part](std::uint32_t vertex) {
      while (part[vertex] != vertex) vertex = part[vertex] = part[part[vertex]];
      return vertex;
    };
    for (const Triangle& t : mesh_.triangles) {
      for (int k = 1; k < 3; ++k) part[root(t[k])] = root(t[0]);
    }
    for (std::uint32_t& each : part) each = root(each);
    return part;
  }

  void find(std::size_t index, Row& row) const {
    row.of_vertex.setZero(static_cast<Eigen::Index>(mesh_.vertices_m.size()), 6);
    row.of_speeds.setZero();
    Eigen::Matrix<double, 3, 6> far = Eigen::Matrix<double, 3, 6>::Zero();  // by point instead of corner
    const Panel& own = panels_[index];
    for (std::size_t j = 0; j < panels_.size(); ++j) {
      const double sizes_m = own.radius_m() + panels_[j].radius_m();
      const double apart = (own.middle_m() - panels_[j].middle_m()).squaredNorm() / (sizes_m * sizes_m);
      if (apart > kFar * kFar) {
        add_far(own, j, row, far);
      } else {
        add_near(own, j, apart > kNear * kNear ? kSomePoints : kManyPoints, j == index, row);
      }
    }
    row.of_speeds += 1.0 / 6 * (far + far.colwise().sum().replicate<3, 1>() + 2 * far);
  }

  void add_curls(std::size_t j, double sources, Row& row) const {
    const Panel& panel = panels_[j];
    for (int c = 0; c < 3; ++c) {
      row.of_vertex.row(corners_[j][c]).head<3>() += sources / (2 * panel.area_m2()) * panel.facing_m(c).transpose();
    }
  }

  void add_far(const Panel& own, std::size_t j, Row& row, Eigen::Matrix<double, 3, 6>& far) const {
    const Panel& panel = panels_[j];
    const double share_m4 = own.area_m2() * panel.area_m2() / 9;
    double sources = 0;
    Eigen::Matrix3d dipoles;  // own point in the row, the panel's in the column
    for (int p = 0; p < 3; ++p) {
      double seen = 0;
      Eigen::Vector3d at = Eigen::Vector3d::Zero();
      for (int q = 0; q < 3; ++q) {
        const Eigen::Vector3d apart_m = own.point_m(p) - panel.point_m(q);
        const double inverse_m = 1 / apart_m.norm();
        seen += inverse_m;
        at += inverse_m * panel.point_m(q);
        dipoles(p, q) = apart_m.dot(panel.normal()) * inverse_m * inverse_m * inverse_m;
      }
      sources += seen;
      far.row(p).head<3>() += share_m4 * seen * panel.normal().transpose();
      far.row(p).tail<3>() += share_m4 * at.cross(panel.normal()).transpose();
    }
    add_curls(j, share_m4 * sources, row);
    const Eigen::Vector3d by_own = dipoles.rowwise().sum();
    const Eigen::RowVector3d by_panel = dipoles.colwise().sum();
    const double all = by_own.sum();
    for (int c = 0; c < 3; ++c) {
      for (int d = 0; d < 3; ++d) {
        row.of_vertex(corners_[j][d], 3 + c) +=
            share_m4 / 36 * (all + 3 * by_own(c) + 3 * by_panel(d) + 9 * dipoles(c, d));
      }
    }
  }

  void add_near(const Panel& own, std::size_t j, const std::vector<Eigen::Vector3d>& points, bool same,
                Row& row) const {
    const Panel& panel = panels_[j];
    const double share_m2 = own.area_m2() / static_cast<double>(points.size());
    double sources = 0;
    for (const Eigen::Vector3d& hats : points) {
      const Eigen::Vector3d at_m = hats(0) * own.corner_m(0) + hats(1) * own.corner_m(1) + hats(2) * own.corner_m(2);
      const Panel::Seen seen = panel.seen_from(at_m, same);
      sources += share_m2 * seen.sources_m;
      Vector6d of_speeds;
      of_speeds << seen.sources_m * panel.normal(), (seen.sources_m * at_m + seen.moment_m2).cross(panel.normal());
      row.of_speeds += share_m2 * hats * of_speeds.transpose();
      for (int d = 0; d < 3; ++d) {
        row.of_vertex.row(corners_[j][d]).tail<3>() += share_m2 * seen.dipoles(d) * hats.transpose();
      }
    }
    add_curls(j, sources, row);
  }

  inline static const std::vector<Eigen::Vector3d> kSomePoints = points_of_halved(1), kManyPoints = points_of_halved(2);

  const TriangleMesh& mesh_;
  std::vector<Panel> panels_;
  std::vector<Triangle> corners_;
};

}  // namespace

Matrix6d added_mass(const TriangleMesh& closed, double density_kg_m3, int threads) {
  require_closed(closed, "mesh");
  require(closed.triangles.size() <= kMostPanels, "mesh.triangles", closed.triangles.size(), "must be at most 10000");
  require(density_kg_m3 > 0 && std::isfinite(density_kg_m3), "density_kg_m3", density_kg_m3, "must be positive");
  return density_kg_m3 * Operators(closed).added_mass(threads);
}

}  // namespace uwsim
