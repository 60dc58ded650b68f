#include "sensors/sensor_bench.h"

namespace uwsim {
namespace {

constexpr double kPi = std::numbers::pi;
using Sensors = SensorBench;

Eigen::Quaterniond turn(double yaw, double pitch = 0, double roll = 0) {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

const Pose kPort{{0, 0.5, 0}, turn(kPi / 2)};

TEST_F(Sensors, PressureAndDepthFollowTheWater) {
  const double compressed_m = truth(sensor_spec("depth")).values[0] - 12;
  EXPECT_NEAR(compressed_m, 12 * 12 * 9806.65 / (2 * 2.1e9), 0.05 * compressed_m) << "d^2 rho g / (2 K)";
  world.water.compressible = false;
  const Pose lower{{0, 0, -0.5}, Eigen::Quaterniond::Identity()};
  EXPECT_NEAR(truth(sensor_spec("pressure")).values[0], 101325 + 1000 * 9.80665 * 12, 1e-6);
  EXPECT_NEAR(truth(sensor_spec("depth", {}, lower)).values[0], 12.5, 1e-12);
  EXPECT_NEAR(truth(sensor_spec("depth", {{"density_kg_m3", {1025}}})).values[0], 12 / 1.025, 1e-12)
      << "a sensor calibrated for the sea reads too little in a lake";
  EXPECT_NEAR(truth(sensor_spec("temperature")).values[0], world.water.temperature_deg_c(-12), 1e-12);
  snapshot.state.world_from_body.position_m.z() = 3;
  EXPECT_EQ(truth(sensor_spec("depth")).values[0], 0) << "in air";
  EXPECT_EQ(truth(sensor_spec("pressure")).values[0], 101325);
}

TEST_F(Sensors, PressureIntegratesAStratifiedProfileAndDepthErrsAccordingly) {
  const std::vector<WaterLevel> levels = {{.depth_m = 0, .temperature_deg_c = 20, .density_kg_m3 = 998},
                                          {.depth_m = 10, .temperature_deg_c = 5, .density_kg_m3 = 1008}};
  world.water.profile = std::make_shared<const WaterProfile>(levels);
  world.water.compressible = false;
  const double column_kg_m2 = 998 * 10 + 10 * 10 / 2 + 1008 * 2;  // in 12 m of water
  EXPECT_NEAR(truth(sensor_spec("pressure")).values[0], 101325 + 9.80665 * column_kg_m2, 1e-6);
  EXPECT_NEAR(truth(sensor_spec("depth")).values[0], column_kg_m2 / 998, 1e-9)
      << "nominal density: that of the surface";
  EXPECT_NEAR(truth(sensor_spec("temperature")).values[0], 5, 1e-12);
}

TEST_F(Sensors, BeyondTheMaximumRangeAltitudeIsInvalidAndProximityReadsThatRange) {
  EXPECT_NEAR(truth(sensor_spec("altitude")).values[0], 8, 1e-9);
  EXPECT_TRUE(truth(sensor_spec("altitude")).valid);
  const Sample far = truth(sensor_spec("altitude", {{"range_max_m", {5}}}));
  EXPECT_TRUE(std::isinf(far.values[0]) && !far.valid);
  const Sample near = truth(sensor_spec("altitude", {{"range_min_m", {9}}}));
  EXPECT_TRUE(near.values[0] == 9 && !near.valid);
  EXPECT_NEAR(truth(sensor_spec("proximity", {{"range_max_m", {10}}}, kPort)).values[0], 5, 1e-9);
  EXPECT_EQ(truth(sensor_spec("proximity", {{"range_max_m", {3}}}, kPort)).values[0], 3) << "as published";
}

TEST_F(Sensors, AnImuMeasuresGravityAtRestAndTheCentripetalForceInATurn) {
  const auto still = truth(sensor_spec("imu")).values;
  EXPECT_NEAR(still[5], 9.80665, 1e-12);
  snapshot.state.velocity_body(5) = 2;  // yaw
  const Pose ahead{{0.3, 0, 0}, Eigen::Quaterniond::Identity()};
  const auto turning = truth(sensor_spec("imu", {}, ahead)).values;
  EXPECT_NEAR(turning[2], 2, 1e-12);
  EXPECT_NEAR(turning[3], -4 * 0.3, 1e-12);
  EXPECT_NEAR(truth(sensor_spec("velocity", {}, ahead)).values[1], 0.6, 1e-12);
  snapshot.state.velocity_body << 1, 0, 0, 0, 0, 2;  // steady motion in a circle: v omega to port
  EXPECT_NEAR(truth(sensor_spec("imu")).values[4], 2, 1e-12);
  EXPECT_NEAR(truth(sensor_spec("acceleration")).values[1], 2, 1e-12);
  EXPECT_NEAR(truth(sensor_spec("acceleration")).values[2], 0, 1e-12) << "without gravity, unlike an IMU";
}

TEST_F(Sensors, AnImusScaleMisalignmentAndSensitivityToForceActOnTheMeasuredVectors) {
  snapshot.state.velocity_body << 0, 0, 0, 0.4, -0.7, 1.1;
  const SensorSpec spec = sensor_spec("imu",
                                      {{"gyro_scale", {0.01, 0.02, -0.03}},
                                       {"gyro_misalignment_rad", {1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3}},
                                       {"gyro_g_sensitivity", {1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4, 7e-4, 8e-4, 9e-4}},
                                       {"accelerometer_scale", {0.04, 0, 0.05}},
                                       {"accelerometer_misalignment_rad", {0, 7e-3, 0, 8e-3, 0, 9e-3}}},
                                      {Eigen::Vector3d::Zero(), turn(0.3, 0.2)});
  const std::vector<double> exact = truth(sensor_spec("imu", {}, spec.body_from_sensor)).values;
  EXPECT_EQ(truth(spec).values, exact) << "errors are no part of the truth";
  const Eigen::Vector3d w = Eigen::Vector3d::Map(&exact[0]), f = Eigen::Vector3d::Map(&exact[3]);
  NoisySensor imu = sensor(spec);
  const std::vector<double> read = imu.read(snapshot, around()).values;
  EXPECT_NEAR(read[0], 1.01 * w.x() + 1e-3 * w.y() + 2e-3 * w.z() + f.dot(Eigen::Vector3d(1e-4, 2e-4, 3e-4)), 1e-12);
  EXPECT_NEAR(read[1], 3e-3 * w.x() + 1.02 * w.y() + 4e-3 * w.z() + f.dot(Eigen::Vector3d(4e-4, 5e-4, 6e-4)), 1e-12);
  EXPECT_NEAR(read[2], 5e-3 * w.x() + 6e-3 * w.y() + 0.97 * w.z() + f.dot(Eigen::Vector3d(7e-4, 8e-4, 9e-4)), 1e-12);
  EXPECT_NEAR(read[3], 1.04 * f.x() + 7e-3 * f.z(), 1e-12);
  EXPECT_NEAR(read[4], f.y() + 8e-3 * f.z(), 1e-12);
  EXPECT_NEAR(read[5], 9e-3 * f.y() + 1.05 * f.z(), 1e-12);
}

TEST_F(Sensors, AFallingImuMeasuresNoForceInAnyAttitudeAndItsOrientation) {
  snapshot.state.world_from_body.orientation = turn(1, 0.4, -2);
  const Eigen::Vector3d down = snapshot.state.world_from_body.orientation.conjugate() * Eigen::Vector3d(0, 0, -9.80665);
  snapshot.acceleration_body.head<3>() = down;
  const auto reading = truth(sensor_spec("imu", {}, {Eigen::Vector3d::Zero(), turn(0.3, 0.2)})).values;
  EXPECT_LT(Eigen::Vector3d::Map(&reading[3]).norm(), 1e-12);
  const Eigen::Quaterniond orientation(Eigen::Vector4d::Map(&reading[6]));
  EXPECT_LT(orientation.angularDistance(turn(1, 0.4, -2) * turn(0.3, 0.2)), 1e-7);
}

TEST_F(Sensors, ADvlMeasuresItsVelocityOverFlatAndSlopingBottomsInAnyAttitude) {
  World slope;
  slope.set_terrain(Heightfield(std::vector<float>{-40, 40, -60, 20}, 2, 2, 400.0, {-200, -200}));
  const RayScene over_slope(slope), &flat = *scene;
  snapshot.state.velocity_body << 1.2, -0.4, 0.3, 0.1, -0.2, 0.5;
  const Pose mount{{0.3, -0.1, -0.2}, turn(0.7, 0.1)};
  const Eigen::Vector3d over_ground =
      mount.orientation.conjugate() *
      (Eigen::Vector3d(1.2, -0.4, 0.3) + Eigen::Vector3d(0.1, -0.2, 0.5).cross(mount.position_m));
  NoisySensor dvl = sensor(sensor_spec("dvl", {{"range_max_m", {1000}}}, mount));
  snapshot.state.world_from_body.position_m = {-20, 5, -3};
  for (const double roll : {0.0, 0.3, -0.45}) {
    for (const double yaw : {0.0, 1.0, 4.0}) {
      snapshot.state.world_from_body.orientation = turn(yaw, 0.2 * yaw - 0.3, roll);
      for (const RayScene* bottom : {&flat, &over_slope}) {
        const Sample sample = dvl.read_true(snapshot, {*bottom, world.water, sound});
        ASSERT_TRUE(sample.valid);
        EXPECT_LT((Eigen::Vector3d::Map(sample.values.data()) - over_ground).norm(), 1e-12);
      }
    }
  }
}

TEST_F(Sensors, DvlBeamsSlantByThirtyDegreesAndBottomLockNeedsThree) {
  const auto level = truth(sensor_spec("dvl")).values;
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(level[3 + static_cast<std::size_t>(k)], 8 / std::cos(kPi / 6), 1e-9);
  snapshot.state.velocity_body(0) = 1;
  const auto ahead = truth(sensor_spec("dvl")).values;
  for (std::size_t k = 0; k < 4; ++k) {
    const double azimuth = kPi / 4 + kPi / 2 * static_cast<double>(k);
    EXPECT_NEAR(ahead[7 + k], std::sin(kPi / 6) * std::cos(azimuth), 1e-12) << "b . v";
  }
  EXPECT_FALSE(truth(sensor_spec("dvl", {{"range_min_m", {10}}})).valid) << "below the minimum range";
  const double reach = 8 / std::cos(kPi / 6);
  EXPECT_TRUE(truth(sensor_spec("dvl", {{"range_max_m", {reach + 1e-3}}})).valid);
  const Sample lost = truth(sensor_spec("dvl", {{"range_max_m", {reach - 1e-3}}}));
  EXPECT_FALSE(lost.valid);
  EXPECT_EQ(lost.values[0], 0);
  EXPECT_EQ(lost.values[11], 0) << "bottom_lock";
  // Rolled until one beam is horizontal; the three others still determine the velocity.
  snapshot.state.world_from_body.orientation = turn(0, 0, -65 * kPi / 180);
  const Sample three = truth(sensor_spec("dvl", {{"beam_azimuth_deg", {0}}}));
  EXPECT_TRUE(three.valid);
  EXPECT_EQ(std::count_if(&three.values[3], &three.values[7], [](double r) { return std::isfinite(r); }), 3);
  EXPECT_NEAR(three.values[0], 1, 1e-12);
  // At an azimuth of 45 degrees, two beams are horizontal, and two hit within 40 m.
  EXPECT_FALSE(truth(sensor_spec("dvl", {{"range_max_m", {40}}})).valid);
}

TEST_F(Sensors, AUsblFixIsThePositionFromTheStationWithinRange) {
  station_world_m = {-30, 10, -1};
  const auto fix = truth(sensor_spec("usbl")).values;
  const Eigen::Vector3d line = Eigen::Vector3d(0, 0, -12) - station_world_m;
  EXPECT_LT((Eigen::Vector3d::Map(fix.data()) - line).norm(), 1e-12);
  EXPECT_NEAR(fix[3], line.norm(), 1e-12);
  EXPECT_NEAR(fix[4], std::atan2(line.y(), line.x()), 1e-12);
  EXPECT_NEAR(fix[5], std::asin(line.z() / line.norm()), 1e-12);
  EXPECT_EQ(Eigen::Vector3d::Map(&fix[6]), station_world_m);
  EXPECT_FALSE(truth(sensor_spec("usbl", {{"range_max_m", {line.norm() - 0.01}}})).valid);
}

TEST_F(Sensors, AUsblFixArrivesAfterTwiceTheTravelTimeAlongTheBentRay) {
  // In a constant gradient g, a ray between ends at equal depth is an arc and takes 2 / g asinh(g x / (2 c)): 0.39738
  // s, compared with 0.4 s along the straight line.
  const double depths[] = {0, 200}, speeds[] = {1450, 1650};
  sound = SoundSpeedProfile(depths, speeds);
  station_world_m = {-600, 0, -50};
  snapshot.state.world_from_body.position_m = {0, 0, -50};
  NoisySensor usbl = sensor(sensor_spec("usbl"));
  usbl.record(snapshot, around());
  VehicleSnapshot later = snapshot;
  later.tick = static_cast<std::uint64_t>(4 * std::asinh(600.0 / 3000) / kStepS);
  EXPECT_FALSE(usbl.read(later, around()).valid);
  ++later.tick;
  EXPECT_LT(static_cast<double>(later.tick) * kStepS, 2 * 600.0 / 1500) << "along the straight line it came later";
  const Sample fix = usbl.read(later, around());
  EXPECT_TRUE(fix.valid);
  EXPECT_EQ(fix.stamp_ns, 0);
  EXPECT_NEAR(fix.values[3], 600, 1e-9);
}

TEST_F(Sensors, AUsblFixIsFromWhereTheStationWasAtThePing) {
  station_world_m = {-30, 10, -1};
  const Eigen::Vector3d line = Eigen::Vector3d(0, 0, -12) - station_world_m;
  NoisySensor usbl = sensor(sensor_spec("usbl"));
  usbl.record(snapshot, around());
  for (const std::uint64_t tick : {40, 400}) {
    VehicleSnapshot later = snapshot;
    later.tick = tick;
    later.station_world_m.x() += 0.01 * static_cast<double>(tick);
    const Sample fix = usbl.read(later, around());
    EXPECT_TRUE(fix.valid);
    EXPECT_LT((Eigen::Vector3d::Map(fix.values.data()) - line).norm(), 1e-12);
  }
}

TEST_F(Sensors, WhereNoRayArrivesThereIsNoUsblFix) {
  const double depths[] = {0, 100}, speeds[] = {1500, 1400};  // rays bend down
  sound = SoundSpeedProfile(depths, speeds);
  scene.emplace(World());
  snapshot.state.world_from_body.position_m = {0, 0, -1};
  station_world_m = {-20, 0, -1};
  EXPECT_TRUE(truth(sensor_spec("usbl")).valid);
  station_world_m = {-600, 0, -1};
  EXPECT_FALSE(truth(sensor_spec("usbl")).valid);
}

TEST_F(Sensors, AUsblFixFromARayThatBouncedIsThePlaceOfTheMirrorImage) {
  const double depths[] = {0, 100}, speeds[] = {1500, 1400};  // rays bend down, away from the station
  sound = SoundSpeedProfile(depths, speeds);
  snapshot.state.world_from_body.position_m = {0, 0, -1};
  station_world_m = {-300, 0, -1};
  const Sample ghost = truth(sensor_spec("usbl"));  // over a bed at 20 m
  EXPECT_TRUE(ghost.valid);
  EXPECT_LT(ghost.values[2], -20) << "below the bed";
  EXPECT_NEAR(ghost.values[3], 300, 10) << "as far away as the ray is long";
}

TEST_F(Sensors, AtTheSurfaceTheDirectRayIsNotMistakenForTheReflectedOne) {
  const double depths[] = {0, 40}, speeds[] = {1476, 1440};
  sound = SoundSpeedProfile(depths, speeds);
  for (const double strongest : {0.0, 1.0}) {
    for (double x = -120; x < -20; x += 7.3) {
      station_world_m = {x, 0, 0};
      const auto fix = truth(sensor_spec("usbl", {{"hears_strongest", {strongest}}}));
      EXPECT_NEAR(fix.values[2], -12, 1e-9);
    }
  }
}

TEST_F(Sensors, AUsblThatCannotResolveTwoArrivalsMeasuresTheGradientOfTheirPhase) {
  sound = SoundSpeedProfile::even(1500);
  scene.emplace(World());
  snapshot.state.world_from_body.position_m = {0, 0, -5};
  station_world_m = {-80, 0, -3};
  const double direct = std::hypot(80, 2), mirrored = std::hypot(80, 8), wave = 2 * kPi * 25e3 / 1500;
  const auto phase = [&](double x, double z) {  // of both at a point near the station, the image with opposite sign
    const double a = std::hypot(80 + x, 2 + z), b = std::hypot(80 + x, 8 - z);
    return std::arg(std::polar(1 / a, wave * a) - std::polar(1 / b, wave * b));
  };
  constexpr double kStep = 1e-5;  // x leads away from the vehicle, z upwards
  const double up = (phase(0, kStep) - phase(0, -kStep)), along = phase(kStep, 0) - phase(-kStep, 0);
  const Sample alone = truth(sensor_spec("usbl", {{"resolution_s", {0.5 * (mirrored - direct) / 1500}}}));
  EXPECT_NEAR(alone.values[5], -std::asin(2 / direct), 1e-9);
  const Sample both = truth(sensor_spec("usbl", {{"resolution_s", {2 * (mirrored - direct) / 1500}}}));
  EXPECT_NEAR(both.values[5], -std::atan2(up, along), 0.01);
  EXPECT_GT(std::abs(both.values[5] - alone.values[5]), 0.02);
  EXPECT_NEAR(both.values[3], direct, 0.02) << "the first arrival sets the range";
}

TEST_F(Sensors, UsblErrorsLieAlongTheLineOfSightAndAcrossIt) {
  station_world_m = {-30, 10, -1};
  SensorSpec spec = sensor_spec("usbl");
  spec.noise["range"].std = 0.1;
  spec.noise["bearing"].std = 0.01;
  NoisySensor usbl = sensor(spec);
  const Eigen::Vector3d line = Eigen::Vector3d(0, 0, -12) - station_world_m, sight = line.normalized();
  const Eigen::Vector3d level = Eigen::Vector3d::UnitZ().cross(sight).normalized();
  double along = 0, sideways = 0, upwards = 0;
  constexpr int kFixes = 20'000;
  for (int k = 0; k < kFixes; ++k) {
    usbl.record(snapshot, around());
    VehicleSnapshot later = snapshot;
    later.tick += 40;  // 0.2 s, which exceeds the travel time
    const Sample fix = usbl.read(later, around());
    ASSERT_EQ(fix.stamp_ns, snapshot.tick * kStepNs);
    const Eigen::Vector3d error = Eigen::Vector3d::Map(fix.values.data()) - line;
    along += std::pow(error.dot(sight), 2);
    sideways += std::pow(error.dot(level), 2);
    upwards += std::pow(error.dot(sight.cross(level)), 2);
    ++snapshot.tick;
  }
  EXPECT_NEAR(std::sqrt(along / kFixes), 0.1, 0.003);
  EXPECT_NEAR(std::sqrt(sideways / kFixes), line.norm() * 0.01, line.norm() * 0.01 * 0.03);
  EXPECT_NEAR(std::sqrt(upwards / kFixes), line.norm() * 0.01, line.norm() * 0.01 * 0.03);
}

TEST_F(Sensors, ACompassMeasuresItsHeadingFromMagneticNorth) {
  for (const double yaw : {0.0, 1.0, 2.5, -2.0}) {
    snapshot.state.world_from_body.orientation = turn(yaw, 0.3, -0.6);
    const double north = std::fmod(kPi / 2 - yaw + 4 * kPi, 2 * kPi);
    EXPECT_NEAR(truth(sensor_spec("compass")).values[0], north, 1e-12);
    const double magnetic = truth(sensor_spec("compass", {{"declination_deg", {10}}})).values[0];
    EXPECT_NEAR(std::remainder(magnetic - (north - 10 * kPi / 180), 2 * kPi), 0, 1e-12);
  }
  // Hard iron to starboard of a level vehicle heading north rotates the measured field east of the bow.
  snapshot.state.world_from_body.orientation = turn(kPi / 2);
  const double deflected = truth(sensor_spec("compass", {{"hard_iron_ut", {0, -5, 0}}})).values[0];
  EXPECT_NEAR(std::remainder(deflected + std::atan2(5, 50 * std::cos(kPi / 3)), 2 * kPi), 0, 1e-12);
}

TEST_F(Sensors, AGyrocompassPointsToTrueNorthAndItsErrorsGrowAsTheSecantOfTheLatitude) {
  snapshot.state.world_from_body.orientation = turn(1.0, 0.3, -0.6);
  EXPECT_NEAR(truth(sensor_spec("gyrocompass")).values[0], kPi / 2 - 1.0, 1e-12);
  const auto error = [&](double latitude_deg) {
    SensorSpec spec = sensor_spec("gyrocompass", {{"latitude_deg", {latitude_deg}}});
    spec.noise["heading"].turn_on_std = 0.002;
    return sensor(spec).read(snapshot, around()).values[0] - (kPi / 2 - 1.0);
  };
  EXPECT_GT(std::abs(error(0)), 1e-5);
  EXPECT_NEAR(error(80) / error(0), 1 / std::cos(80 * kPi / 180), 1e-9);
}

TEST_F(Sensors, ACtdReturnsTheSalinityOfItsConductivity) {
  const std::vector<WaterLevel> levels = {
      {.depth_m = 0, .temperature_deg_c = 15 / 1.00024, .salinity_psu = 35, .density_kg_m3 = 1026},
      {.depth_m = 4000, .temperature_deg_c = 2, .salinity_psu = 34, .density_kg_m3 = 1028}};
  world.water.profile = std::make_shared<const WaterProfile>(levels);
  snapshot.state.world_from_body.position_m.z() = -1e-6;
  EXPECT_NEAR(truth(sensor_spec("ctd")).values[0], 42.914, 1e-4) << "C(35, 15, 0), by definition of the scale";
  for (const double depth_m : {1.0, 300.0, 3999.0}) {
    snapshot.state.world_from_body.position_m.z() = -depth_m;
    const Sample here = truth(sensor_spec("ctd"));
    EXPECT_NEAR(here.values[3], world.water.salinity_at_psu(-depth_m), 1e-9);
    EXPECT_NEAR(here.values[2], 1e-4 * (world.water.pressure_pa(-depth_m) - 101325), 1e-9);
    EXPECT_TRUE(here.valid);
  }
  world.water.profile = nullptr;
  EXPECT_EQ(truth(sensor_spec("ctd")).values[0], 0) << "fresh water";
  snapshot.state.world_from_body.position_m.z() = 1;
  const Sample dry = truth(sensor_spec("ctd"));
  EXPECT_TRUE(!dry.valid && dry.values[0] == 0 && dry.values[3] == 0);
}

TEST_F(Sensors, ATideRaisesPressureAndTheSurface) {
  const double before_pa = truth(sensor_spec("pressure")).values[0];
  world.water.compressible = false;
  const double still_pa = truth(sensor_spec("pressure")).values[0];
  world.water.tide = std::make_shared<const Tide>(std::vector<TidalConstituent>{{1.5, 1.4e-4, 0}});
  EXPECT_NEAR(truth(sensor_spec("pressure")).values[0] - still_pa, 1.5 * 9806.65, 1e-6);
  EXPECT_GT(before_pa, still_pa);
  EXPECT_NEAR(world.water.surface_height_at(3, 4, kPi / 1.4e-4), -1.5, 1e-9);
}

TEST_F(Sensors, ContactIsOneWhileInContact) {
  EXPECT_EQ(truth(sensor_spec("contact")).values[0], 0);
  snapshot.touching = true;
  EXPECT_EQ(truth(sensor_spec("contact")).values[0], 1);
}

TEST_F(Sensors, AnInvalidSpecIsRefusedByName) {
  const auto message = [&](const SensorSpec& spec) {
    try {
      sensor(spec);
    } catch (const InvalidValue& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(sensor_spec("dvl", {{"range_max_m", {-1}}})),
            "sensors.dvl.range_max_m = -1 m: must be in [0.1, 1000] m");
  EXPECT_EQ(message(sensor_spec("proximity")), "sensors.proximity.range_max_m = missing: must be given");
  EXPECT_NE(message(sensor_spec("sonnar")).find("must be one of imu, position, velocity"), std::string::npos);
  EXPECT_NE(message(sensor_spec("depth", {{"range_max_m", {1}}})).find("must be one of density_kg_m3"),
            std::string::npos);
  SensorSpec spec = sensor_spec("depth");
  spec.noise["depth"].std = -1;
  EXPECT_NE(message(spec).find("sensors.depth.depth.std = -1"), std::string::npos);
  spec.noise = {{"pressure", {}}};
  EXPECT_NE(message(spec).find("must be one of depth"), std::string::npos);
  spec.noise = {};
  spec.drop_out = 1;
  EXPECT_NE(message(spec).find("sensors.depth.drop_out = 1"), std::string::npos);
}

}  // namespace
}  // namespace uwsim
