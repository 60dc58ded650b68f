#include "uwsim/control/pid.h"

namespace uwsim {

double Pid::output(double error, double now, const PidGains& gains, double period_s) {
  const double change = begun ? now - measured : 0;
  derivative = (gains.filter_s * derivative - gains.derivative * change) / (gains.filter_s + period_s);
  measured = now;
  begun = true;
  error_ = error;
  output_ = gains.proportional * error + integral + derivative;
  return output_;
}

void Pid::settle(double applied, const PidGains& gains, double period_s) {
  integral += period_s * (gains.integral * error_ + (applied - output_) / gains.tracking_s);
}

}  // namespace uwsim
