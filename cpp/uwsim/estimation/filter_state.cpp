#include "uwsim/estimation/filter_state.h"

#include <cmath>

namespace uwsim {

double BiasModel::decay(double dt_s) const {
  return drift_time_s > 0 && turn_on_std == 0 && walk == 0 ? std::exp(-dt_s / drift_time_s) : 1;
}

double BiasModel::growth(double dt_s) const {
  const double walked = walk * walk * dt_s;
  if (!(drift_time_s > 0)) return walked;
  const double kept = decay(dt_s);
  return kept < 1 ? drift_std * drift_std * (1 - kept * kept)
                  : walked + 2 * drift_std * drift_std * dt_s / drift_time_s;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Quaterniond rotation_by(const Eigen::Vector3d& angle_rad) {
  const double angle = angle_rad.norm();
  const double share = angle > 1e-6 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = share * angle_rad;
  return q;
}

void FilterState::add(const ErrorVector& error) {
  position_m += error.segment<3>(kPosition);
  velocity_m_s += error.segment<3>(kVelocity);
  orientation = (orientation * rotation_by(error.segment<3>(kAttitude))).normalized();
  rate_bias_rad_s += error.segment<3>(kRateBias);
  force_bias_m_s2 += error.segment<3>(kForceBias);
  aid_bias += error.tail(errors() - kAidBias);
}

}  // namespace uwsim
