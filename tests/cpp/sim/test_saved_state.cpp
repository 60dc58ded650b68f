#include <gtest/gtest.h>

#include <random>

#include "refusal.h"
#include "sim/scene.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sim/simulation.h"

namespace uwsim {
namespace {

/// A craft with a lagging thruster, a fin and sensors with internal state, which drops onto a sloping bed.
VehicleSpec craft(const std::string& name, const Eigen::Vector3d& position_m) {
  VehicleSpec spec = vehicle_of(name, position_m, dragged(brick(), 1050));
  ThrusterParameters thruster = aft_thruster();
  thruster.time_constant_s = 0.3;
  spec.actuators.thrusters = {thruster};
  FinParameters fin;
  fin.name = "rudder";
  fin.span_body = Eigen::Vector3d::UnitZ();
  fin.deflection_max_rad = 0.5;
  fin.rate_max_rad_s = 0.2;
  spec.actuators.fins = {fin};
  SensorSpec depth{.name = "depth", .kind = "depth", .body_from_sensor = {}, .parameters = {}, .noise = {}};
  depth.rate_hz = 7;
  depth.latency_s = 0.31;
  depth.drop_out = 0.3;
  depth.noise["depth"] = {.std = 0.1, .walk = 0.05};
  SensorSpec imu{.name = "imu", .kind = "imu", .body_from_sensor = {}, .parameters = {}, .noise = {}};
  imu.noise["angular_velocity"] = {.std = 0.1, .bias_std = 0.02, .bias_time_s = 30};
  spec.sensors = {depth, imu};
  spec.sonars.resize(1);
  spec.sonars[0].name = "sonar";
  return spec;
}

Simulation two_craft(const World& world, std::uint64_t seed = 3, EngineKind engine = EngineKind::kUwsim) {
  SimulationSpec spec;
  spec.seed = seed;
  spec.engine = engine;
  Simulation sim = simulation(world, spec);
  sim.add_vehicle(craft("first", {0, 0, -10}));
  VehicleSpec second = craft("second", {0.3, 0.2, -8.8});  // falls onto the first
  second.docked = true;
  sim.add_vehicle(second);
  return sim;
}

class SavedState : public ::testing::Test {
 protected:
  SavedState() { world.set_terrain(Heightfield({-11, -11, -12, -12}, 2, 2, 400.0, {-200, -200})); }

  static void act(Simulation& sim) {
    sim.actuators(0).set_thrusters({{"aft", 0.8}});
    sim.actuators(0).set_fins({{"rudder", 0.4}});
    sim.step(150);
    sim.release(1);
    sim.aim(0, 0, -0.4);
    sim.step(250);
    sim.read_sensor(0, 0);
  }

  /// Everything that can be observed in the next `steps` steps, as exact bits.
  static std::string future(Simulation& sim, int steps) {
    std::string seen;
    const auto note = [&](const double* values, std::size_t n) {
      seen.append(reinterpret_cast<const char*>(values), n * sizeof(double));
    };
    for (int k = 0; k < steps; ++k) {
      sim.step();
      for (std::size_t v = 0; v < 2; ++v) {
        const BodyState& state = sim.state(v);
        note(state.world_from_body.position_m.data(), 3);
        note(state.world_from_body.orientation.coeffs().data(), 4);
        note(state.velocity_body.data(), 6);
        for (std::size_t s = 0; s < 2; ++s) {
          const Sample& sample = sim.read_sensor(v, s);
          note(sample.values.data(), sample.values.size());
          seen += sample.valid ? '1' : '0';
          seen += std::to_string(sample.stamp_ns);
        }
        seen += std::to_string(sim.collisions(v)) + (sim.telemetry(v).collision_warning ? "touching" : "free");
        note(sim.world_from_sonar(v, 0).orientation.coeffs().data(), 4);
      }
    }
    return seen + std::to_string(sim.time_ns()) + " " + std::to_string(sim.telemetry(1).mission_time_s);
  }

  World world;
};

TEST_F(SavedState, ARestoredSimulationHasTheSameFutureToTheBit) {
  for (const EngineKind engine : {EngineKind::kUwsim, EngineKind::kBullet}) {
    Simulation sim = two_craft(world, 3, engine);
    act(sim);
    const std::string state = sim.save_state(kHere);
    const std::string expected = future(sim, 600);
    ASSERT_GT(sim.collisions(0) + sim.collisions(1), 0u) << "the test needs contacts";
    Simulation fresh = two_craft(world, 3, engine);
    fresh.restore_state(state, kHere);
    EXPECT_EQ(fresh.save_state(kHere), state);
    EXPECT_EQ(future(fresh, 600), expected);
  }
}

TEST_F(SavedState, StatesSavedInContactHaveTheSameFutureToo) {
  Simulation sim = two_craft(world);
  act(sim);
  bool touching = false;
  for (int moment = 0; moment < 12; ++moment) {
    sim.step(75);
    touching = touching || sim.telemetry(0).collision_warning;
    Simulation fresh = two_craft(world);
    fresh.restore_state(sim.save_state(kHere), kHere);
    Simulation other = two_craft(world);
    other.restore_state(sim.save_state(kHere), kHere);
    sim.step(40);
    fresh.step(40);
    ASSERT_EQ(fresh.save_state(kHere), sim.save_state(kHere)) << moment;
    sim.restore_state(other.save_state(kHere), kHere);
  }
  EXPECT_TRUE(touching);
}

TEST_F(SavedState, SavingDoesNotChangeTheFuture) {
  Simulation saved = two_craft(world), left = two_craft(world);
  act(saved);
  act(left);
  saved.save_state(kHere);
  EXPECT_EQ(future(saved, 100), future(left, 100));
}

TEST_F(SavedState, AStateOfAnotherOriginIsRefusedAndChangesNothing) {
  Simulation sim = two_craft(world);
  act(sim);
  const std::string state = sim.save_state(kHere);
  Simulation fresh = two_craft(world), other_seed = two_craft(world, 4);
  const std::string before = fresh.save_state(kHere);
  EXPECT_THROW(fresh.restore_state(state, {"another scenario", "a build"}), InvalidValue);
  EXPECT_THROW(other_seed.restore_state(state, kHere), InvalidValue);
  Simulation alone = simulation(world);
  EXPECT_THROW(alone.restore_state(state, kHere), InvalidValue);
  EXPECT_EQ(fresh.save_state(kHere), before);
  fresh.restore_state(state, {"a scenario", "another build"});
  EXPECT_EQ(fresh.save_state(kHere), state);
  EXPECT_EQ(saved_build(state), "a build");
}

TEST_F(SavedState, DamageToAnyByteIsDetected) {
  Simulation sim = two_craft(world);
  act(sim);
  const std::string state = sim.save_state(kHere);
  Simulation fresh = two_craft(world);
  const std::string before = fresh.save_state(kHere);
  for (std::size_t size = 0; size < state.size(); size += 7)
    EXPECT_THROW(fresh.restore_state(state.substr(0, size), kHere), InvalidValue) << size;
  EXPECT_THROW(fresh.restore_state(state + "x", kHere), InvalidValue);
  for (std::size_t byte = 0; byte < state.size(); ++byte) {
    std::string flipped = state;
    flipped[byte] = static_cast<char>(flipped[byte] ^ (1 << (byte % 8)));
    EXPECT_THROW(fresh.restore_state(flipped, kHere), InvalidValue) << byte;
  }
  EXPECT_EQ(fresh.save_state(kHere), before);
}

/// A forged state with a matching checksum is refused, or restored and simulated, without a crash.
TEST_F(SavedState, AForgedStateDoesNotCrash) {
  for (const EngineKind engine : {EngineKind::kUwsim, EngineKind::kBullet}) {
    Simulation sim = two_craft(world, 3, engine);
    act(sim);
    const std::string content(unwrapped_state(sim.save_state(kHere), kHere));
    std::mt19937 draw(1);
    int restored = 0, refused = 0;
    Simulation fresh = two_craft(world, 3, engine);
    for (int k = 0; k < 3000; ++k) {
      std::string forged = content;
      for (int change = 0; change < 1 + k % 4; ++change) forged[draw() % forged.size()] = static_cast<char>(draw());
      if (k % 10 == 0) forged.resize(draw() % forged.size());
      try {
        fresh.restore_state(wrapped_state(forged, kHere), kHere);
        ++restored;
        fresh.step(2);
        fresh.read_sensor(0, 0);
        fresh.read_sensor(1, 0);
        fresh.ping(0, 0);
      } catch (const InvalidValue&) {
        ++refused;
      }
    }
    EXPECT_GT(restored, 0);
    EXPECT_GT(refused, 0);
  }
}

constexpr std::uint64_t kSoon = 1200;

/// Two craft connected by a modem, with messages waiting and in flight.
Simulation linked_craft(const World& world) {
  Simulation sim = two_craft(world);
  sim.set_link({});
  for (const std::size_t from : {1, 2}) {
    LinkMessage message;
    message.topic = sim.link().topic("odom");
    message.payload.assign(200, 'x');
    message.repeats = 2;
    sim.link().send(from, message, 0);
  }
  sim.step(kSoon);
  return sim;
}

/// Sets eight bytes at a time of a state with a link, so that an index, a count or a time becomes far too large. Each
/// byte is set two or three times: with the bytes before it, and with those after it.
TEST_F(SavedState, AForgedNumberAnywhereDoesNotCrash) {
  Simulation sim = linked_craft(world), fresh = two_craft(world);
  fresh.set_link({});
  ASSERT_GT(sim.link().waiting_messages(1) + sim.link().waiting_messages(2), 0u);
  const std::string content(unwrapped_state(sim.save_state(kHere), kHere));
  int restored = 0, refused = 0;
  for (std::size_t at = 0; at + 8 <= content.size(); at += 3) {
    std::string forged = content;
    for (std::size_t k = 0; k < 8; ++k) forged[at + k] = at % 2 == 0 ? '\xff' : '\x7f';
    try {
      fresh.restore_state(wrapped_state(forged, kHere), kHere);
      ++restored;
      fresh.step(kSoon);  // until messages have been sent and have arrived
    } catch (const InvalidValue&) {
      ++refused;
    }
  }
  EXPECT_GT(restored, 0);
  EXPECT_GT(refused, 0);
}

TEST_F(SavedState, ALinkOfAnotherVersionIsRefusedByItsVersion) {
  const auto bytes = [](std::uint64_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  Simulation sim = linked_craft(world), fresh = two_craft(world);
  fresh.set_link({});
  const std::string content(unwrapped_state(sim.save_state(kHere), kHere)), now = bytes(PacketNetwork::kLayout);
  int refused = 0;
  for (std::size_t at = content.find(now); at != std::string::npos; at = content.find(now, at + 1)) {
    std::string older = content;
    older.replace(at, now.size(), bytes(1));
    refused += refusal([&] { fresh.restore_state(wrapped_state(older, kHere), kHere); }) ==
               "state.link.version = 1: must be 3: another version of uwsim saved it";
  }
  EXPECT_EQ(refused, 1) << "only one of these numbers is the version";
}

TEST(StateArchive, NonFiniteValuesAreRefused) {
  StateArchive saved;
  double nothing = std::nan("");
  saved(nothing);
  StateArchive restored(saved.bytes());
  EXPECT_THROW(restored(nothing), InvalidValue);
}

}  // namespace
}  // namespace uwsim
