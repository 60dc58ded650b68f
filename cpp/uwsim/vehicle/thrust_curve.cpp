#include "uwsim/vehicle/thrust_curve.h"

#include <cmath>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/vehicle/polyline.h"

namespace uwsim {

ThrustCurve::ThrustCurve(std::vector<double> commands, std::vector<double> thrusts_n, std::string_view path)
    : commands_(std::move(commands)), thrusts_n_(std::move(thrusts_n)) {
  require(commands_.size() >= 2 && commands_.size() == thrusts_n_.size(), path, commands_.size(),
          "must have at least 2 points, each a command and a thrust");
  for (std::size_t k = 0; k < commands_.size(); ++k) {
    require(std::abs(commands_[k]) <= 1, path, commands_[k], "commands must be in [-1, 1]");
    require(std::isfinite(thrusts_n_[k]), path, thrusts_n_[k], "thrusts must be finite");
    require(k == 0 || commands_[k] > commands_[k - 1], path, commands_[k], "commands must increase");
    require(k == 0 || thrusts_n_[k] >= thrusts_n_[k - 1], path, thrusts_n_[k], "thrusts must not fall");
  }
  require(commands_.front() <= 0 && commands_.back() >= 0 && thrust_n(0) == 0, path, thrust_n(0),
          "command 0 must give 0 N");
}

double ThrustCurve::thrust_n(double command) const { return interpolated(commands_, thrusts_n_, command); }

double ThrustCurve::command(double thrust_n) const {
  return thrust_n == 0 ? 0 : interpolated(thrusts_n_, commands_, thrust_n);
}

}  // namespace uwsim
