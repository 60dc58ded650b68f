#include "uwsim/camera/ripples.h"

#include <gtest/gtest.h>

#include "uwsim/camera/caustics.h"

namespace uwsim {
namespace {

TEST(Ripples, CausticsConserveLightAndSlopesHaveTheVarianceOfCoxAndMunk) {
  const Ripples ripples(5, 0.3, 11);
  const Ripples::Snapshot snapshot = ripples.at(3.7, 1.333, 0, 2);
  for (int level = 0; level < camera::kCausticLevels; ++level) {
    double sum = 0, square = 0;
    for (std::size_t k = static_cast<std::size_t>(level); k < snapshot.caustics.size(); k += camera::kCausticLevels) {
      sum += snapshot.caustics[k], square += snapshot.caustics[k] * snapshot.caustics[k];
    }
    const double cells = Ripples::kCells * Ripples::kCells;
    EXPECT_NEAR(sum / cells, 1, 1e-4) << level;
    EXPECT_GT(square / cells, 1.005) << level;  // the light is uneven
  }
  double variance = 0;
  for (const float slope : snapshot.slopes) variance += slope * slope;
  EXPECT_NEAR(variance / (Ripples::kCells * Ripples::kCells), 0.5 * (0.003 + 0.00512 * 5), 0.15 * 0.0143);
}

}  // namespace
}  // namespace uwsim
