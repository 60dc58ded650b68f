#include "uwsim/world/sound_speed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/world/water.h"

namespace uwsim {
namespace {

using enum SoundSpeedEquation;

constexpr double kBar = 1e5;
constexpr double kT68PerT90 = 1.00024;

/// The equation of 1974 as published, for temperatures on the 1968 scale; pressure in kg/cm^2.
double del_grosso_1974(double t, double s, double p) {
  return 1402.392 + (0.501109398873e1 - (0.550946843172e-1 - 0.221535969240e-3 * t) * t) * t +
         (0.132952290781e1 + 0.128955756844e-3 * s) * s +
         (0.156059257041e0 + (0.244998688441e-4 - 0.883392332513e-8 * p) * p) * p - 0.127562783426e-1 * t * s +
         0.635191613389e-2 * t * p + 0.265484716608e-7 * t * t * p * p - 0.159349479045e-5 * t * p * p +
         0.522116437235e-9 * t * p * p * p - 0.438031096213e-6 * t * t * t * p - 0.161674495909e-8 * s * s * p * p +
         0.968403156410e-4 * t * t * s + 0.485639620015e-5 * t * s * s * p - 0.340597039004e-3 * t * s * p;
}

TEST(SoundSpeed, AgreesWithPublishedCheckValues) {
  EXPECT_NEAR(sound_speed_m_s(25, 35, 1000, "mackenzie"), 1550.744, 1e-3);
  EXPECT_NEAR(sound_speed_m_s(kUnesco, 40 / kT68PerT90, 40, 9000, 1000 * kBar), 1731.995, 0.02) << "UNESCO 44";
  EXPECT_NEAR(sound_speed_m_s(0, 0, 0, "unesco"), 1402.388, 1e-9);
  EXPECT_NEAR(sound_speed_m_s(20, 0, 0, "belogolskii"), 1482.35, 0.05) << "IAPWS-95 (NIST): 1482.3 m/s";
}

TEST(SoundSpeed, DelGrossosEquationForTheScaleOf1990IsThatOf1974) {
  for (const double t : {0.0, 10.0, 20.0, 30.0}) {
    for (const double s : {30.0, 35.0, 40.0}) {
      for (const double p : {0.0, 300.0, 1000.0}) {
        EXPECT_NEAR(sound_speed_m_s(kDelGrosso, t / kT68PerT90, s, 0, p * 98066.5), del_grosso_1974(t, s, p), 0.02);
      }
    }
  }
}

/// Marczak 1997, J. Acoust. Soc. Am. 102:2776: distilled water at atmospheric pressure.
TEST(SoundSpeed, InPureWaterIsThatOfMarczak) {
  for (double t = 0; t <= 40; t += 5) {
    const double marczak =
        1.402385e3 + t * (5.038813 + t * (-5.799136e-2 + t * (3.287156e-4 + t * (-1.398845e-6 + t * 2.787860e-9))));
    EXPECT_NEAR(sound_speed_m_s(t, 0, 0, "belogolskii"), marczak, 0.05) << t;
    EXPECT_NEAR(sound_speed_m_s(t, 0, 0, "unesco"), marczak, 0.05) << t;
  }
  EXPECT_NEAR(sound_speed_m_s(10, 0, 3000, "belogolskii"), sound_speed_m_s(10, 0, 3000, "unesco"), 0.3);
}

struct Sample {
  double t, s, d;
};

TEST(SoundSpeed, TheEquationsAgreeInTheirCommonRange) {
  for (const auto& [t, s, d] : {Sample{20, 36, 0}, {10, 35, 1000}, {4, 35, 2000}, {2, 34.8, 5000}}) {
    EXPECT_NEAR(sound_speed_m_s(t, s, d, "leroy"), sound_speed_m_s(t, s, d, "del_grosso"), 0.3) << d;
    EXPECT_NEAR(sound_speed_m_s(t, s, d, "unesco"), sound_speed_m_s(t, s, d, "del_grosso"), 0.7) << d;
    EXPECT_NEAR(sound_speed_m_s(t, s, d, "mackenzie"), sound_speed_m_s(t, s, d, "del_grosso"), 1.0) << d;
  }
  for (const auto& [t, s, d] : {Sample{10, 8, 50}, {20, 0, 0}, {5, 18, 500}, {25, 40, 900}}) {
    EXPECT_NEAR(sound_speed_m_s(t, s, d, "leroy"), sound_speed_m_s(t, s, d, "unesco"), 0.4) << d;
    EXPECT_NEAR(sound_speed_m_s(t, s, d, "medwin"), sound_speed_m_s(t, s, d, "unesco"), 1.3) << d;
  }
}

TEST(SoundSpeed, TheBestEquationIsValidInAllOfTheWater) {
  EXPECT_EQ(best_sound_speed_equation({4, 20, 0, 0, 40}), kBelogolskii);
  EXPECT_EQ(best_sound_speed_equation({4, 20, 0, 35, 40}), kUnesco);
  EXPECT_EQ(best_sound_speed_equation({4, 20, 34, 36, 40}), kUnesco);
  EXPECT_EQ(best_sound_speed_equation({2, 20, 34, 36, 4000}), kDelGrosso);
  EXPECT_EQ(best_sound_speed_equation({-1, 10, 34, 35, 4000}), kLeroy);
}

TEST(SoundSpeed, AWaterSelectsItsEquationAndRefusesOneThatIsNotValidInIt) {
  Water lake;
  lake.select_sound_speed_equation("automatic");
  EXPECT_EQ(lake.sound_speed_equation, kBelogolskii);
  EXPECT_NEAR(lake.sound_speed_m_s(-40), sound_speed_m_s(6, 0, 40, "belogolskii"), 1e-3);
  EXPECT_THROW(lake.select_sound_speed_equation("mackenzie"), InvalidValue) << "fresh";
  EXPECT_THROW(lake.select_sound_speed_equation("wilson"), InvalidValue);
  lake.select_sound_speed_equation("medwin");
  EXPECT_DOUBLE_EQ(lake.sound_speed_m_s(-40), sound_speed_m_s(6, 0, 40, "medwin"));
  lake.profile = std::make_shared<const WaterProfile>(std::vector{WaterLevel{.sound_speed_m_s = 1450}});
  EXPECT_EQ(lake.sound_speed_m_s(-10), 1450);
  EXPECT_THROW(lake.select_sound_speed_equation("medwin"), InvalidValue) << "the profile gives it";
}

TEST(SoundSpeed, InvalidArgumentsAreRefused) {
  for (const double bad : {-3.0, std::nan(""), 1e9}) {
    for (const std::string& name : sound_speed_equation_names()) {
      EXPECT_THROW(sound_speed_m_s(bad, 35, 10, name), InvalidValue);
      EXPECT_THROW(sound_speed_m_s(10, bad, 10, name), InvalidValue);
      EXPECT_THROW(sound_speed_m_s(10, 35, bad, name), InvalidValue);
    }
  }
  EXPECT_THROW(sound_speed_m_s(10, 35, 10, ""), InvalidValue);
}

}  // namespace
}  // namespace uwsim
