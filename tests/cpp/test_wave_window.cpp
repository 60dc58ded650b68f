#include "uwsim/camera/wave_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace uwsim {
namespace {

// What a camera sees of the surface is what a hull floats in.
TEST(WaveField, HeightsAreThoseThatVehiclesFeel) {
  const std::vector<WaveComponent> components{{0.4, 1.1, 0.3, 0.7}, {0.15, 2.3, -1.2, 2.9}, {0.05, 4.0, 2.0, 0.1}};
  Water water;
  water.waves = std::make_shared<Waves>(components, 30.0);
  const Eigen::Vector3d centre(12.3, -7.8, -2);
  for (const double time_s : {0.0, 3.7, 1234.5}) {
    const WaveField field(water, centre, time_s);
    const camera::WaveWindow window = field.window();
    ASSERT_NE(window.cells, nullptr);
    const WaveField shared(water, centre, time_s, 3);
    EXPECT_TRUE(std::equal(window.cells, window.cells + 3 * window.side * window.side, shared.window().cells));
    for (int j = 0; j < window.side; j += 17) {
      for (int i = 0; i < window.side; i += 13) {
        const double x = centre.x() + window.left + i * window.spacing;
        const double y = centre.y() + window.bottom + j * window.spacing;
        const float* node = window.cells + 3 * (j * window.side + i);
        EXPECT_NEAR(node[0], water.surface_height_at(x, y, time_s), 2e-5) << i << " " << j << " at " << time_s;
        const double rise = water.surface_height_at(x + 1e-3, y, time_s) - water.surface_height_at(x - 1e-3, y, time_s);
        EXPECT_NEAR(node[1], rise / 2e-3, 1e-4) << i << " " << j << " at " << time_s;
      }
    }
  }
}

}  // namespace
}  // namespace uwsim
