#include "uwsim/control/pid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

/// With K_p = 2 w and K_i = w^2, the loop around y' = u has a double pole at w: e = (1 - w t) exp(-w t).
TEST(Pid, AnIntegratorAnswersAStepAsItsClosedForm) {
  constexpr double w = 2, period_s = 1e-3;
  const PidGains gains{.proportional = 2 * w, .integral = w * w};
  Pid pid;
  double y = 0;
  for (int k = 0; k < 4000; ++k) {
    const double t = k * period_s;
    ASSERT_NEAR(1 - y, (1 - w * t) * std::exp(-w * t), 3e-3) << t;
    const double u = pid.output(1 - y, y, gains, period_s);
    pid.settle(u, gains, period_s);
    y += u * period_s;
  }
}

/// While u = u_max, dI/dt = K_i e + (u_max - K_p e - I) / T_t, so I converges to u_max - K_p e + T_t K_i e from any
/// start.
TEST(Pid, ASaturatedIntegralForgetsItsStartWithTheTrackingTime) {
  constexpr double period_s = 0.05, error = 2, most = 1;
  const PidGains gains{.proportional = 3, .integral = 4, .tracking_s = 0.5};
  const double end = most - gains.proportional * error + gains.tracking_s * gains.integral * error;
  Pid pid(100, 0, 0);
  for (int k = 1; k <= 60; ++k) {
    ASSERT_GT(pid.output(error, 0, gains, period_s), most) << "it is saturated";
    pid.settle(most, gains, period_s);
    ASSERT_NEAR(pid.integral - end, (100 - end) * std::pow(1 - period_s / gains.tracking_s, k), 1e-9);
  }
}

/// Around y' = u with |u| <= 1 and a distant target, the overshoot with anti-windup is a small fraction of that
/// without.
TEST(Pid, AfterALongSaturationNothingIsWoundUp) {
  constexpr double period_s = 0.01, target = 20;
  double overshoot[2];
  for (const bool settles : {false, true}) {
    const PidGains gains{.proportional = 2, .integral = 1, .tracking_s = 1};
    Pid pid;
    double y = 0, highest = 0;
    for (int k = 0; k < 10000; ++k) {
      const double wish = pid.output(target - y, y, gains, period_s), u = std::clamp(wish, -1.0, 1.0);
      pid.settle(settles ? u : wish, gains, period_s);
      y += u * period_s;
      highest = std::max(highest, y);
    }
    overshoot[settles] = highest - target;
  }
  EXPECT_GT(overshoot[0], 5);
  EXPECT_LT(overshoot[1], 0.5);
}

/// For a ramp of the measurement, D = -K_d dy/dt (1 - (T_f / (T_f + T))^k); a step of the target has no effect on D.
TEST(Pid, TheDerivativeIsOfTheMeasurementAndFiltered) {
  constexpr double period_s = 0.1, slope = 5;
  const PidGains gains{.derivative = 2, .filter_s = 0.3};
  Pid pid;
  for (int k = 0; k < 40; ++k) {
    const double target = k < 20 ? 0 : 7, y = slope * period_s * k;
    ASSERT_NEAR(pid.output(target - y, y, gains, period_s), -2 * slope * (1 - std::pow(0.75, k)), 1e-12);
  }
}

/// A Pid constructed from the state of another continues like the other.
TEST(Pid, GoesOnFromAPeriodBefore) {
  constexpr double period_s = 0.1;
  const PidGains gains{.proportional = 1, .integral = 2, .derivative = 0.5};
  Pid first;
  first.output(0.4, -0.4, gains, period_s);
  first.settle(0.3, gains, period_s);
  Pid second(first.integral, first.derivative, first.measured);
  EXPECT_EQ(first.output(0.2, -0.2, gains, period_s), second.output(0.2, -0.2, gains, period_s));
}

}  // namespace
}  // namespace uwsim
