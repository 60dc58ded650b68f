#include "uwsim/dynamics/link_loads.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/dynamics/spatial.h"

namespace uwsim {
namespace {

/// mass (r^2 1 - r r^T): what a point adds to an inertia.
Eigen::Matrix3d moment_of_point(double mass_kg, const Eigen::Vector3d& r) {
  return mass_kg * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
}

}  // namespace

void LinkSum::add_point(double point_kg, const Eigen::Vector3d& at_m) {
  const double x = at_m.x(), y = at_m.y(), z = at_m.z();
  const double mx = point_kg * x, my = point_kg * y, mz = point_kg * z;
  mass_kg += point_kg;
  first_moment_kg_m += Eigen::Vector3d(mx, my, mz);
  xx += my * y + mz * z;
  yy += mx * x + mz * z;
  zz += mx * x + my * y;
  xy -= mx * y;
  xz -= mx * z;
  yz -= my * z;
}

void LinkSum::write(Matrix6d& mass, Vector6d& bias) const {
  const double x = first_moment_kg_m.x(), y = first_moment_kg_m.y(), z = first_moment_kg_m.z();
  mass.setZero();
  for (int k = 0; k < 3; ++k) {
    mass(k, k) = mass_kg;
    bias(k) = force_n(k);
    bias(k + 3) = moment_nm(k);
  }
  mass(4, 0) = mass(0, 4) = z;
  mass(5, 0) = mass(0, 5) = -y;
  mass(3, 1) = mass(1, 3) = -z;
  mass(5, 1) = mass(1, 5) = x;
  mass(3, 2) = mass(2, 3) = y;
  mass(4, 2) = mass(2, 4) = -x;
  mass(3, 3) = xx;
  mass(4, 4) = yy;
  mass(5, 5) = zz;
  mass(4, 3) = mass(3, 4) = xy;
  mass(5, 3) = mass(3, 5) = xz;
  mass(5, 4) = mass(4, 5) = yz;
}

void RigidPart::add(const PlacedLink& at, const ArmLink& link) {
  add(link.mass_kg, at.origin_m + at.base_from_link * link.centre_of_mass_m,
      at.base_from_link * link.inertia_kg_m2 * at.base_from_link.transpose());
}

void RigidPart::add(double mass_kg, const Eigen::Vector3d& centre_m, const Eigen::Matrix3d& inertia_kg_m2) {
  const Eigen::Vector3d both_m = (mass_kg_ * centre_m_ + mass_kg * centre_m) / (mass_kg_ + mass_kg);
  inertia_kg_m2_ +=
      moment_of_point(mass_kg_, centre_m_ - both_m) + moment_of_point(mass_kg, centre_m - both_m) + inertia_kg_m2;
  centre_m_ = both_m;
  mass_kg_ += mass_kg;
}

void RigidPart::add_to(LinkSum& sum, const PlacedLink& at, const Vector6d& velocity,
                       const Eigen::Vector3d& lift_m_s2) const {
  if (mass_kg_ == 0) return;
  const Eigen::Matrix3d& r = at.base_from_link;
  const Eigen::Matrix3d& i = inertia_kg_m2_;
  // R I R^T, by rows and without 3 x 3 temporaries, which would go through memory.
  double t[3][3];
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) t[row][k] = r(row, 0) * i(0, k) + r(row, 1) * i(1, k) + r(row, 2) * i(2, k);
  }
  const auto turned = [&](int a, int b) { return t[a][0] * r(b, 0) + t[a][1] * r(b, 1) + t[a][2] * r(b, 2); };
  const double xx = turned(0, 0), xy = turned(0, 1), xz = turned(0, 2);
  const double yy = turned(1, 1), yz = turned(1, 2), zz = turned(2, 2);
  const Eigen::Vector3d linear = velocity.head<3>(), spin = velocity.tail<3>();
  const Eigen::Vector3d centre_m = at.origin_m + r * centre_m_;
  const Eigen::Vector3d turning(xx * spin.x() + xy * spin.y() + xz * spin.z(),
                                xy * spin.x() + yy * spin.y() + yz * spin.z(),
                                xz * spin.x() + yz * spin.y() + zz * spin.z());
  sum.moment_nm += spin.cross(turning);
  sum.add_force(centre_m, mass_kg_ * (spin.cross(linear + spin.cross(centre_m)) + lift_m_s2));
  sum.add_point(mass_kg_, centre_m);
  sum.xx += xx;
  sum.xy += xy;
  sum.xz += xz;
  sum.yy += yy;
  sum.yz += yz;
  sum.zz += zz;
}

ArmLinkWater::ArmLinkWater(const ArmLink& link, const PlacedLink& at)
    : volume_m3_(link.volume_m3),
      diameter_m_(std::cbrt(6 * link.volume_m3 / std::numbers::pi)),
      at_(at),
      centre_m_(at.origin_m + at.base_from_link * link.centre_of_buoyancy_m),
      is_turned_(!at.base_from_link.isIdentity(0)),
      has_drag_(!link.linear_drag.isZero(0) || !link.quadratic_drag.isZero(0)),
      has_turning_drag_(!link.linear_drag.tail<3>().isZero(0) || !link.quadratic_drag.tail<3>().isZero(0)),
      has_any_added_mass_(false),
      added_kg_(link.added_mass(0, 0)),
      added_at_m_(at.origin_m),
      added_mass_(link.added_mass),
      linear_drag_(link.linear_drag),
      quadratic_drag_(link.quadratic_drag) {
  if (added_kg_ > 0) {
    const Eigen::Vector3d at_m(added_mass_(5, 1), added_mass_(3, 2), added_mass_(4, 0));
    added_at_m_ = at_.origin_m + at_.base_from_link * (at_m / added_kg_);
  }
  const Eigen::Vector3d in_link_m = at_.base_from_link.transpose() * (added_at_m_ - at_.origin_m);
  const Eigen::Matrix3d across = cross_matrix_of(in_link_m);
  Matrix6d point;
  point << added_kg_ * Eigen::Matrix3d::Identity(), -added_kg_ * across, added_kg_ * across,
      -added_kg_ * across * across;
  has_any_added_mass_ = (added_mass_ - point).cwiseAbs().maxCoeff() > 1e-12 * added_mass_.cwiseAbs().maxCoeff();
}

double ArmLinkWater::submerged(const Eigen::Vector3d& centre_world_m, const BaseSurroundings& around) const {
  if (volume_m3_ == 0) return centre_world_m.z() < 0 ? 1 : 0;
  if (centre_world_m.z() < -diameter_m_ - around.water.wave_bound_m()) return 1;
  const double surface_m = around.water.surface_height_at(centre_world_m.x(), centre_world_m.y(), around.time_s);
  return std::clamp(0.5 + (surface_m - centre_world_m.z()) / diameter_m_, 0.0, 1.0);
}

Eigen::Vector3d ArmLinkWater::drag_along_link(const Eigen::Vector3d& v, int first) const {
  const auto along = [&](int k) {
    return -(linear_drag_(first + k) + quadratic_drag_(first + k) * std::abs(v(k))) * v(k);
  };
  return {along(0), along(1), along(2)};
}

void ArmLinkWater::add_drag(LinkSum& sum, const PlacedLink& frame, const Eigen::Vector3d& centre_m,
                            const Eigen::Vector3d& relative_m_s, const Eigen::Vector3d& spin, double wet) const {
  if (!has_drag_) return;
  const Eigen::Matrix3d turned =
      is_turned_ ? Eigen::Matrix3d(frame.base_from_link * at_.base_from_link) : frame.base_from_link;
  const Eigen::Vector3d through = turned.transpose() * (relative_m_s + spin.cross(centre_m));
  sum.add_force(centre_m, turned * (-wet * drag_along_link(through, 0)));
  if (has_turning_drag_) sum.moment_nm += turned * (-wet * drag_along_link(turned.transpose() * spin, 3));
}

double ArmLinkWater::add_to(LinkSum& sum, Matrix6d& mass, Vector6d& bias, const PlacedLink& frame,
                            const Vector6d& velocity, const BaseSurroundings& around) const {
  const Eigen::Vector3d centre_m = frame.origin_m + frame.base_from_link * centre_m_;
  const Eigen::Vector3d centre_world_m = around.position_world_m + around.world_from_base * centre_m;
  const double wet = submerged(centre_world_m, around);
  if (wet == 0) return 0;
  const Eigen::Vector3d linear = velocity.head<3>(), spin = velocity.tail<3>();
  const double displaced_kg = wet * around.water.density_at(centre_world_m.z()) * volume_m3_;
  const WaterFlow flow = around.water.flow_at(centre_world_m, around.time_s);
  const Eigen::Vector3d moving = around.world_from_base.transpose() * flow.velocity_m_s;
  const Eigen::Vector3d rate =
      around.world_from_base.transpose() * (flow.wave_acceleration_m_s2 + flow.current_acceleration_m_s2);
  const Eigen::Vector3d relative = linear - moving;
  const double lift_n = displaced_kg * around.gravity_m_s2;
  const Eigen::Vector3d at_centre_n = lift_n * around.world_from_base.row(2).transpose() + displaced_kg * rate;
  sum.add_force(centre_m, -at_centre_n);
  add_drag(sum, frame, centre_m, relative, spin, wet);
  const Eigen::Vector3d water_rate = rate - spin.cross(moving);
  if (has_any_added_mass_) {
    const PlacedLink at = frame * at_;
    const Matrix6d added = SpatialTransform{at.base_from_link, at.origin_m}.inertia_to_parent(wet * added_mass_);
    Vector6d through;
    through << relative, spin;
    mass += added;
    bias += cross_force(through, added * through) - added.leftCols<3>() * water_rate;
  } else if (added_kg_ > 0) {
    const Eigen::Vector3d origin_m = frame.origin_m + frame.base_from_link * added_at_m_;
    const double added_kg = wet * added_kg_;
    sum.add_force(origin_m, added_kg * (spin.cross(relative + spin.cross(origin_m)) - water_rate));
    sum.add_point(added_kg, origin_m);
  }
  return lift_n;
}

void ImmersedPart::add(const PlacedLink& at, const ArmLink& link, const ArmLinkWater& water) {
  all_.add(at, link);
  if (water.added_kg_ > 0) all_.add(water.added_kg_, water.added_at_m_, Eigen::Matrix3d::Zero());
  mass_kg_ += link.mass_kg;
  volume_m3_ += link.volume_m3;
  added_kg_ += water.added_kg_;
  mass_moment_ += link.mass_kg * (at.origin_m + at.base_from_link * link.centre_of_mass_m);
  volume_moment_ += link.volume_m3 * water.centre_m_;
  added_moment_ += water.added_kg_ * water.added_at_m_;
  if (water.has_drag_) dragged_.push_back(water);
}

void ImmersedPart::add_to(LinkSum& sum, const PlacedLink& at, const Vector6d& velocity,
                          const EvenSurroundings& around) const {
  all_.add_to(sum, at, velocity, Eigen::Vector3d::Zero());
  const auto add = [&](double kg, const Eigen::Vector3d& moment_kg_m, const Eigen::Vector3d& rate_m_s2) {
    sum.force_n += kg * rate_m_s2;
    sum.moment_nm += (kg * at.origin_m + at.base_from_link * moment_kg_m).cross(rate_m_s2);
  };
  const double displaced_kg = around.density_kg_m3 * volume_m3_;
  const Eigen::Vector3d displaced_moment = around.density_kg_m3 * volume_moment_;
  add(mass_kg_ - displaced_kg, mass_moment_ - displaced_moment, around.lift_m_s2);
  if (!around.rate_m_s2.isZero(0)) add(-displaced_kg - added_kg_, -displaced_moment - added_moment_, around.rate_m_s2);
  const Eigen::Vector3d relative = velocity.head<3>() - around.velocity_m_s, spin = velocity.tail<3>();
  for (const ArmLinkWater& link : dragged_)
    link.add_drag(sum, at, at.origin_m + at.base_from_link * link.centre_m_, relative, spin, 1);
}

}  // namespace uwsim
