#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "dynamics/tethers.h"

namespace uwsim::tether_itself_tests {  // other files have some of these names, too
namespace {

constexpr double kDiameter_m = 0.02, kMass_kg = 5;
constexpr std::uint64_t kElements = 120;

EvenWater weightless(double density_kg_m3) {
  EvenWater water;
  water.density_kg_m3 = density_kg_m3;
  water.gravity_m_s2 = 0;
  return water;
}

/// A trefoil: (t^3 - 3 t, t^4 - 4 t^2, t^5 / 5 - 2 t), in decimetres (Shastri 1992, Tohoku Math. J. 44:11). Without the
/// knot, the same seen from above, but rising all the way.
Eigen::Vector3d trefoil(double t, bool is_knot) {
  const double z = t * t * t * t * t / 5 - 2 * t;
  return 0.1 * Eigen::Vector3d(t * t * t - 3 * t, t * t * t * t - 4 * t * t, is_knot ? z : t);
}

/// Points along it, evenly spaced.
std::vector<Eigen::Vector3d> points(bool is_knot) {
  constexpr int kFine = 200000;
  constexpr double kEnd = 2.3;
  std::vector<double> along = {0};
  for (int k = 1; k <= kFine; ++k) {
    const auto at = [&](int n) { return trefoil(kEnd * (2.0 * n / kFine - 1), is_knot); };
    along.push_back(along.back() + (at(k) - at(k - 1)).norm());
  }
  std::vector<Eigen::Vector3d> found;
  for (std::uint64_t i = 0; i <= kElements; ++i) {
    const double wanted = along.back() * static_cast<double>(i) / kElements;
    const auto k = std::min<std::ptrdiff_t>(std::ranges::lower_bound(along, wanted) - along.begin(), kFine);
    found.push_back(trefoil(kEnd * (2.0 * static_cast<double>(k) / kFine - 1), is_knot));
  }
  return found;
}

double length_m(const std::vector<Eigen::Vector3d>& nodes) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) sum += (nodes[i + 1] - nodes[i]).norm();
  return sum;
}

/// A tether between two blocks, put into a shape.
class Shaped {
 public:
  Shaped(const std::vector<Eigen::Vector3d>& nodes, double friction, double damping_n_s_m, const WaterField& water)
      : bodies({}, kStep_s) {
    CraftParameters p;
    p.mass_kg = kMass_kg;
    p.linear_damping.diagonal().head<3>().setConstant(damping_n_s_m);
    p.inertia_kg_m2 = Eigen::Vector3d(0.05, 0.05, 0.05).asDiagonal();
    const auto craft = craft_of(p, testing::box(0.01, 0.01, 0.01));
    for (const Eigen::Vector3d& end : {nodes.front(), nodes.back()}) {
      bodies.add_body({"block " + std::to_string(bodies.size()), craft}, at(kDeep + end));
    }
    TetherSpec spec;
    spec.first.body = 0;
    spec.second.body = 1;
    spec.length_m = length_m(nodes);
    spec.elements = nodes.size() - 1;
    spec.diameter_m = kDiameter_m;
    spec.mass_kg_m = 0.08;
    spec.bending_stiffness_n_m2 = 1e-4;
    spec.friction = friction;
    bodies.add_tether(spec, water, 0);
    put(nodes);
  }

  const Tether& tether() const { return bodies.tether(0); }

  void step(const WaterField& water) { bodies.step(water, steps++ * kStep_s); }

  void pull(double force_n) {
    const Eigen::Vector3d way = (place_m(bodies, 1) - place_m(bodies, 0)).normalized();
    for (const std::size_t k : {0u, 1u}) {
      Loads loads{.body = Vector6d::Zero(), .world = Vector6d::Zero()};
      loads.world.head<3>() = (k == 0 ? -force_n : force_n) * way;
      bodies.apply(k, loads);
    }
  }

  double apart_m() const { return (tether().position_m(0) - tether().position_m(kElements)).norm(); }

  Eigen::Vector3d momentum() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::size_t k : {0u, 1u}) sum += kMass_kg * velocity_m_s(bodies, k);
    return sum + uwsim::momentum(tether());
  }

  double energy_j() const {
    double sum = uwsim::energy_j(tether(), 0) + contact_energy_j(tether());
    for (const std::size_t k : {0u, 1u}) sum += bodies.spec(k).craft->kinetic_energy_j(bodies.state(k));
    return sum;
  }

  RigidBodyWorld bodies;
  int steps = 0;

 private:
  static inline const Eigen::Vector3d kDeep{0, 0, -50};

  /// Through the saved state, in which a node is its position, velocity and grip, and a tension.
  void put(const std::vector<Eigen::Vector3d>& nodes) {
    StateArchive saved;
    bodies.exchange_tethers(saved);
    std::string bytes = saved.bytes();
    const Eigen::Vector3d first = tether().position_m(0);
    std::string wanted(sizeof(double) * 3, '\0');
    std::memcpy(wanted.data(), first.data(), wanted.size());
    const std::size_t begin = bytes.find(wanted);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Eigen::Vector3d place = kDeep + nodes[i];
      const double values[10] = {place.x(), place.y(), place.z(), 0, 0, 0, place.x(), place.y(), place.z(), 0};
      std::memcpy(&bytes[begin + i * sizeof values], values, sizeof values);
    }
    StateArchive shaped(bytes);
    bodies.exchange_tethers(shaped);
    EXPECT_EQ(tether().position_m(3), kDeep + nodes[3]);
  }
};

/// The least distance of elements with more tether between them than a tight bend takes, in diameters.
double closest_d(const Tether& tether) {
  double least = 1e9;
  for (std::size_t i = 0; i < kElements; ++i) {
    for (std::size_t j = i + 8; j < kElements; ++j) {
      for (const double s : {0.0, 0.25, 0.5, 0.75}) {
        for (const double t : {0.0, 0.25, 0.5, 0.75}) {
          const Eigen::Vector3d one = (1 - s) * tether.position_m(i) + s * tether.position_m(i + 1);
          const Eigen::Vector3d two = (1 - t) * tether.position_m(j) + t * tether.position_m(j + 1);
          least = std::min(least, (one - two).norm() / kDiameter_m);
        }
      }
    }
  }
  return least;
}

TEST(TetherItself, KnotPulledTightHolds) {
  const EvenWater water = weightless(1000);
  for (const bool is_knot : {true, false}) {
    Shaped rig(points(is_knot), 0.3, 20, water);
    double least_d = 1e9;
    for (int k = 0; k < 2000; ++k) {
      rig.pull(20 * std::min(1.0, k / 1000.0));
      rig.step(water);
      if (k % 100 == 0) least_d = std::min(least_d, closest_d(rig.tether()));
    }
    const double short_d = (rig.tether().length_m() - rig.apart_m()) / kDiameter_m;
    EXPECT_NEAR(rig.tether().tension_n(0), 20, 2) << is_knot;
    if (is_knot) {
      EXPECT_GT(short_d, 8) << "a tight overhand knot takes about 12 diameters";
      EXPECT_LT(short_d, 40);
      EXPECT_GT(least_d, 0.7);
    } else {
      EXPECT_LT(short_d, 1) << "it is drawn straight";
    }
  }
}

/// The planes of contacts are those of the step's start, so that energy may grow, by some thousandths.
TEST(TetherItself, EnergyDoesNotGrowAndMomentumHolds) {
  const EvenWater water = weightless(1e-12);
  for (const double friction : {0.0, 0.5}) {
    Shaped rig(points(true), friction, 0, water);
    for (int k = 0; k < 100; ++k) {
      rig.pull(2);
      rig.step(water);
    }
    rig.pull(0);
    const Eigen::Vector3d momentum = rig.momentum();
    const double start = rig.energy_j();
    double least = start;
    int touching = 0;
    for (int k = 0; k < 600; ++k) {
      rig.step(water);
      const double now = rig.energy_j();
      ASSERT_LE(now, least + 5e-3 * start) << k << ", friction " << friction;
      least = std::min(least, now);
      touching += std::ranges::any_of(rig.tether().contacts(), [](const auto& c) { return c.force_n > 0; });
      ASSERT_LT((rig.momentum() - momentum).norm(), 1e-7) << k;
    }
    EXPECT_GT(touching, 200) << friction;
  }
}

}  // namespace
}  // namespace uwsim::tether_itself_tests
