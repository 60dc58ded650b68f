#include "uwsim/camera/wave_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace uwsim {
namespace {

// A camera sees the same surface that a hull floats in.
TEST(WaveGrid, HoldsTheHeightsAndSlopesThatVehiclesFeel) {
  const std::vector<WaveComponent> components{{0.4, 1.1, 0.3, 0.7}, {0.15, 2.3, -1.2, 2.9}, {0.05, 4.0, 2.0, 0.1}};
  Water water;
  water.waves = std::make_shared<Waves>(components, 30.0);
  const Eigen::Vector3d centre(12.3, -7.8, -2);
  for (const double time_s : {0.0, 3.7, 1234.5}) {
    const WaveGrid grid(water, centre, time_s);
    const camera::WaveNodes nodes = grid.nodes();
    ASSERT_NE(nodes.values, nullptr);
    const WaveGrid threaded(water, centre, time_s, 3);
    EXPECT_TRUE(std::equal(nodes.values, nodes.values + 3 * nodes.side * nodes.side, threaded.nodes().values));
    for (int j = 0; j < nodes.side; j += 17) {
      for (int i = 0; i < nodes.side; i += 13) {
        const double x = centre.x() + nodes.left_m + i * nodes.spacing_m;
        const double y = centre.y() + nodes.bottom_m + j * nodes.spacing_m;
        const float* node = nodes.values + 3 * (j * nodes.side + i);
        EXPECT_NEAR(node[0], water.surface_height_at(x, y, time_s), 2e-5) << i << " " << j << " at " << time_s;
        const double rise = water.surface_height_at(x + 1e-3, y, time_s) - water.surface_height_at(x - 1e-3, y, time_s);
        EXPECT_NEAR(node[1], rise / 2e-3, 1e-4) << i << " " << j << " at " << time_s;
      }
    }
  }
}

}  // namespace
}  // namespace uwsim
