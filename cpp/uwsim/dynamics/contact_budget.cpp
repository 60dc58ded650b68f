#include "uwsim/dynamics/contact_budget.h"

#include <sstream>

namespace uwsim {
namespace {

constexpr double kHuge_m = 50;  // few vehicles are larger; the unit is probably wrong

}  // namespace

void ContactBudget::begin(std::size_t body, const Eigen::Vector3d& size_m) {
  body_ = body;
  size_m_ = size_m;
  spent_ = triangles_ = 0;
}

void ContactBudget::refuse() const {
  const bool is_huge = size_m_.maxCoeff() > kHuge_m;
  std::ostringstream message;
  message.precision(4);
  message << "contact search = more than " << kMostTests << " tests of features: " << triangles_
          << " triangles of terrain and solids are near its shape of " << size_m_.x() << " x " << size_m_.y() << " x "
          << size_m_.z() << " m, must be fewer: "
          << (is_huge ? "is its mesh in millimetres? set mesh_scale"
                      : "use a coarser mesh or spacing_m, or `collision: box`");
  throw ContactBudgetExceeded(body_, message.str());
}

}  // namespace uwsim
