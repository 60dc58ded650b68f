#pragma once

namespace uwsim {

/// Gains of a PID controller in parallel form.
struct PidGains {
  double proportional = 0;  ///< [u / e]
  double integral = 0;      ///< [u / (e s)]
  double derivative = 0;    ///< [u s / e]
  double filter_s = 0.1;    ///< time constant of the derivative filter
  /// Time constant with which the integral of a saturated output is pulled back towards the achievable output; at least
  /// one period
  double tracking_s = 1;
};

/// A PID controller with a filtered derivative of the measurement and anti-windup by back-calculation (Astrom and
/// Hagglund 2006, "Advanced PID Control", sec. 3.3 and 3.5):
///
///   u = K_p e + I + D,  dI/dt = K_i e + (u_applied - u) / T_t,  T_f dD/dt + D = -K_d dy/dt
///
/// discretised by forward and backward differences (their sec. 13.4). Call `output`, then `settle` with the value that
/// the actuators actually delivered.
class Pid {
 public:
  Pid() = default;
  /// Continues from the state of the previous period.
  Pid(double integral, double derivative, double measured)
      : integral(integral), derivative(derivative), measured(measured), begun(true) {}

  /// The output requested in this period.
  double output(double error, double measured, const PidGains& gains, double period_s);
  /// Completes the period: updates the integral with the error and with the difference between the applied and the
  /// requested output.
  void settle(double applied, const PidGains& gains, double period_s);

  double integral = 0;    ///< I, in units of the output
  double derivative = 0;  ///< D
  double measured = 0;    ///< of the previous period
  bool begun = false;     ///< false if there was no previous period

 private:
  double error_ = 0, output_ = 0;  // of this period
};

}  // namespace uwsim
