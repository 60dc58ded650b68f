#include "uwsim/camera/thin_solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

constexpr double kThin_m = 0.1;

}  // namespace

ThinSolidsAround::ThinSolidsAround(const std::vector<ThinSolid>& solids, const Eigen::Vector3d& eye_m,
                                   double angle_rad) {
  constexpr float kRounding = 1e-4f;
  for (const ThinSolid& solid : solids) {
    const Eigen::Array3d low = (solid.low_m - eye_m).array(), high = (solid.high_m - eye_m).array();
    const double wider_m = angle_rad * low.abs().max(high.abs()).matrix().norm();
    Box box{low - wider_m, high + wider_m, Eigen::Vector3f::UnitX(), -2};
    const Eigen::Vector3d middle = 0.5 * (box.low_m + box.high_m).matrix();
    const double radius_m = 0.5 * (box.high_m - box.low_m).matrix().norm(), away_m = middle.norm();
    if (away_m > radius_m) {
      box.towards = (middle / away_m).cast<float>();
      box.least_cosine = static_cast<float>(std::sqrt(1 - std::pow(radius_m / away_m, 2))) - kRounding;
    }
    boxes_.push_back(box);
  }
}

bool ThinSolidsAround::are_met(const Eigen::Vector3f& direction) const {
  const auto is_met = [&](const Box& box) {
    if (direction.dot(box.towards) < box.least_cosine) return false;
    double enters = 0, leaves = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double slope = static_cast<double>(direction(axis));
      if (slope == 0) continue;  // such a ray is within some other block's angle
      const double one = box.low_m(axis) / slope, other = box.high_m(axis) / slope;
      enters = std::max(enters, std::min(one, other)), leaves = std::min(leaves, std::max(one, other));
    }
    return enters <= leaves;
  };
  return std::ranges::any_of(boxes_, is_met);
}

double mean_thickness_m(const TriangleMesh& mesh) {
  double volume = 0, area = 0;
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d& first = mesh.vertices_m.front();
    const Eigen::Vector3d a = mesh.vertices_m[t[0]] - first, b = mesh.vertices_m[t[1]] - first,
                          c = mesh.vertices_m[t[2]] - first;
    volume += a.dot(b.cross(c)) / 6;
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  return area > 0 ? 4 * std::abs(volume) / area : 0;
}

std::vector<ThinSolid> thin_solids(const World& world) {
  std::vector<ThinSolid> found;
  std::uint32_t label = kTerrain;
  for (const auto& solid : world.solids()) {
    ++label;
    const TriangleMesh& mesh = solid->mesh_world;
    const double thickness_m = mean_thickness_m(mesh);
    if (!(thickness_m > 0 && thickness_m < kThin_m)) continue;
    ThinSolid thin{label, static_cast<float>(thickness_m), mesh.vertices_m.front(), mesh.vertices_m.front()};
    for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
      thin.low_m = thin.low_m.cwiseMin(vertex), thin.high_m = thin.high_m.cwiseMax(vertex);
    }
    found.push_back(thin);
  }
  return found;
}

}  // namespace uwsim
