#include "uwsim/world/plume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "meshes.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

PlumeSpec spec() {
  PlumeSpec spec;
  spec.name = "leak";
  spec.count = 200;
  spec.shapes_m = {{testing::box(0.1, 0.1, 0.1)}, {testing::box(0.2, 0.2, 0.2)}};
  spec.source_world_m = {3, -2, -12};
  spec.drift_m_s = {0.1, -0.05, 0};
  return spec;
}

TEST(Plume, ClustersRiseAndDriftSteadily) {
  const Plume plume(spec());
  std::vector<Swimmer> before(plume.size()), after(plume.size());
  plume.place(1000, before);
  plume.place(1001, after);
  int rising = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < before.size(); ++k) {
    const Eigen::Vector3d moved = after[k].position_world_m - before[k].position_world_m;
    if (moved.z() < 0) continue;  // it has started again
    ++rising;
    EXPECT_NEAR(moved.z(), spec().rise_m_s, 1e-9);
    mean += moved;
  }
  EXPECT_GE(rising, 190);
  EXPECT_LT((mean / rising - Eigen::Vector3d(0.1, -0.05, spec().rise_m_s)).norm(), 5e-3);
}

TEST(Plume, NineOfTenClustersAreWithinItsRadiusAndAllWithinItsReach) {
  const Plume plume(spec());
  std::vector<Swimmer> clusters(plume.size());
  int within = 0, all = 0;
  for (double time_s = 0; time_s < 2000; time_s += 53) {
    plume.place(time_s, clusters);
    for (const Swimmer& one : clusters) {
      const double height_m = one.position_world_m.z() + 12;
      const Eigen::Vector3d axis = spec().source_world_m + height_m / spec().rise_m_s * spec().drift_m_s;
      within += (one.position_world_m - axis).head<2>().norm() < 0.01 + 0.1 * height_m ? 1 : 0;
      ++all;
      EXPECT_LE((one.position_world_m - plume.middle_world_m()).norm(), plume.reach_m());
      EXPECT_TRUE(height_m >= 0 && height_m <= 12);
      EXPECT_EQ(one.size, height_m < 6 ? 0u : 1u);
      EXPECT_TRUE(one.rotation().isUnitary(1e-9));
    }
  }
  EXPECT_NEAR(static_cast<double>(within) / all, 0.9, 0.01);
}

TEST(Plume, RefusesWhatCannotRise) {
  PlumeSpec flat = spec();
  flat.top_z_m = -13;
  EXPECT_THROW(Plume{flat}, InvalidValue);
}

}  // namespace
}  // namespace uwsim
