#include "uwsim/world/cover.h"

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kMostPerM2 = 1000;
constexpr double kSmallest_m = 1e-3, kLargest_m = 100;
constexpr double kSmallestPatch_m = 0.01;
constexpr double kMostDrag = 10;

}  // namespace

void CoverLayer::check() const {
  const std::string path = "cover '" + name + "' ";
  require(!meshes.empty(), path + "meshes", 0, "must not be empty");
  for (const TriangleMesh& mesh : meshes) require_well_formed(mesh, path + "mesh");
  require(density_per_m2 >= 0 && density_per_m2 <= kMostPerM2, path + "density_per_m2", density_per_m2,
          "must be in [0, 1000]");
  require(size_m.low >= kSmallest_m && size_m.low <= size_m.high && size_m.high <= kLargest_m, path + "size_m",
          size_m.low, "must be ascending and in [0.001, 100] m");
  require(std::abs(size_exponent) <= 10, path + "size_exponent", size_exponent, "must be in [-10, 10]");
  require(sunk >= -0.5 && sunk <= 1, path + "sunk", sunk, "must be in [-0.5, 1]");
  require(patch_m == 0 || (patch_m >= kSmallestPatch_m && std::isfinite(patch_m)), path + "patch_m", patch_m,
          "must be 0, or finite and at least 0.01 m");
  for (const CoverRange& range : {depth_m, slope_rad, from_solids_m})
    require(range.low <= range.high, path + "range", range.low, "must not be above its end");
  require(drag_coefficient >= 0 && drag_coefficient <= kMostDrag, path + "drag_coefficient", drag_coefficient,
          "must be in [0, 10]");
  require(patch_share > 0 && patch_share <= 1, path + "patch_share", patch_share, "must be in (0, 1]");
  require(leans_at_m_s > 0, path + "leans_at_m_s", leans_at_m_s, "must be positive");
}

}  // namespace uwsim
