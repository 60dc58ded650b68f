#include "uwsim/camera/thin_solids.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "uwsim/camera/block_lane.h"

namespace uwsim {
namespace {

constexpr double kThin_m = 0.1;

}  // namespace

ThinSolidsAround::ThinSolidsAround(const std::vector<ThinSolid>& solids, const std::vector<float>& least_m,
                                   const Eigen::Vector3d& eye_m, float aside)
    : aside_(aside) {
  constexpr double kRounding = 1e-4;
  const auto set = [](camera::BlockVectors& sides, std::size_t lane, const Eigen::Vector3d& corner_m) {
    camera::set_lane(corner_m.cast<float>(), lane, sides);
  };
  std::size_t count = 0;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    const Eigen::Vector3d low = solids[k].low_m - eye_m, high = solids[k].high_m - eye_m;
    const double farthest_m = low.cwiseAbs().cwiseMax(high.cwiseAbs()).norm();
    if (farthest_m < static_cast<double>(least_m[k])) continue;
    const std::size_t lane = count++ % camera::kBlockPixels;
    if (lane == 0) std::ranges::fill(boxes_.emplace_back().least.at, std::numeric_limits<float>::infinity());
    const Eigen::Vector3d wider_m = Eigen::Vector3d::Constant(kRounding * farthest_m);
    set(boxes_.back().low, lane, low - wider_m), set(boxes_.back().high, lane, high + wider_m);
    boxes_.back().least.at[lane] = static_cast<float>(1 - kRounding) * least_m[k];
  }
}

bool ThinSolidsAround::may_be_met(const camera::Kernels& kernels, const Eigen::Vector3f& origin_m,
                                  const Eigen::Vector3f& direction) const {
  return std::ranges::any_of(boxes_, [&](const camera::BoxLanes& boxes) {
    return kernels.may_meet(boxes, origin_m.data(), direction.data(), aside_);
  });
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
