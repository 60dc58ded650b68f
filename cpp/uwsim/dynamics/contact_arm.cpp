#include "uwsim/dynamics/contact_arm.h"

namespace uwsim {

void ContactArm::extend(const Vector6d& row, int link, Eigen::VectorXd& extended) const {
  extended.setZero(size());
  extended.head<6>() = row;
  if (link < 0) return;
  for (std::size_t k = joint_of_link[static_cast<std::size_t>(link)]; k != kNone; k = joints[k].parent)
    extended[6 + static_cast<Eigen::Index>(k)] = row.dot(joints[k].axis);
}

double ContactArm::speed_along(const Vector6d& row, int link, double Joint::*of) const {
  double sum = 0;
  if (link < 0) return sum;
  for (std::size_t k = joint_of_link[static_cast<std::size_t>(link)]; k != kNone; k = joints[k].parent)
    sum += row.dot(joints[k].axis) * joints[k].*of;
  return sum;
}

}  // namespace uwsim
