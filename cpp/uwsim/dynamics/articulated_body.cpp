#include "uwsim/dynamics/articulated_body.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/dynamics/contact_arm.h"
#include "uwsim/dynamics/spatial.h"

namespace uwsim {

ArticulatedBody::ArticulatedBody(std::vector<ArmLink> links) : links_(std::move(links)), work_(links_.size()) {
  check_links(links_);
  carriers_.resize(size() + 1);
  joints_.resize(size());
  lift_n_.resize(size());
  weight_n_.resize(size());
  order_.resize(size());
  composite_.resize(size());
  pushes_world_.resize(size() + 1, Vector6d::Zero());
  for (std::size_t k = 0; k < size(); ++k) {
    const ArmLink& link = links_[k];
    const bool on_base = link.parent == ArmLink::kBase;
    const std::uint64_t parent = on_base ? ArmLink::kBase : carrier_[link.parent];
    PlacedLink mount{link.parent_from_link.rotation(), link.parent_from_link.position_m};
    if (!on_base) mount = in_carrier_[link.parent] * mount;
    const bool moves = link.joint != ArmLink::Joint::kFixed;
    if (moves) {
      Joint& joint = joints_[k];
      joint.turn = mount.base_from_link;
      joint.axis = link.axis.normalized();
      const Eigen::Matrix3d across = cross_matrix_of(joint.axis);
      joint.by_sine = joint.turn * across;
      joint.by_cosine = joint.turn * across * across;
      joint.origin_m = mount.origin_m;
      joint.slide = joint.turn * joint.axis;
      joint.parent = parent;
      order_[k] = moving_.size();
      moving_.push_back(k);
    }
    carrier_.push_back(moves ? k : parent);
    in_carrier_.push_back(moves ? PlacedLink{} : mount);
    water_.emplace_back(link, in_carrier_[k]);
    Carrier& carrier = carriers_[carrier_[k] == ArmLink::kBase ? size() : carrier_[k]];
    carrier.rigid.add(in_carrier_[k], link);
    carrier.immersed.add(in_carrier_[k], link, water_[k]);
    has_directions_ = has_directions_ || water_[k].has_directions();
    way_m_.push_back((on_base ? 0 : way_m_[link.parent]) + link.parent_from_link.position_m.norm());
    double extent_m = water_[k].extent_m();
    if (link.surface_m != nullptr) {
      for (const Eigen::Vector3d& corner : link.surface_m->vertices_m) extent_m = std::max(extent_m, corner.norm());
    }
    reach_m_ = std::max(reach_m_, way_m_[k] + extent_m);
    carrier.links.push_back(k);
  }
}

void ArticulatedBody::place(const BodyState& base, std::span<const double> positions, std::span<const double> speeds,
                            const WaterField& water, double time_s) {
  base_ = base;
  const BaseSurroundings around{water, time_s, water.gravity(), base.world_from_body.rotation(),
                                base.world_from_body.position_m};
  for (const std::size_t k : moving_) place_link(k, positions[k], speeds[k]);
  const auto each = [&](const auto& add) {
    add(carriers_[size()], PlacedLink{}, base.velocity_body, fixed_.inertia, fixed_.bias);
    for (const std::size_t k : moving_) {
      Work& at = work_[k];
      add(carriers_[k], at.placed, at.velocity, at.mass, at.own_bias);
    }
  };
  if (is_immersed(base, positions, water)) {
    const Eigen::Matrix3d base_from_world = around.world_from_base.transpose();
    const WaterFlow flow = water.flow_at(base.world_from_body.position_m, time_s);
    const EvenSurroundings even{water.density_at(base.world_from_body.position_m.z()),
                                around.gravity_m_s2 * base_from_world.col(2), base_from_world * flow.velocity_m_s,
                                base_from_world * flow.current_acceleration_m_s2};
    for (std::size_t k = 0; k < size(); ++k) {
      weight_n_[k] = links_[k].mass_kg * around.gravity_m_s2;
      lift_n_[k] = links_[k].volume_m3 * even.density_kg_m3 * around.gravity_m_s2;
    }
    each([&](const Carrier& carrier, const PlacedLink& at, const Vector6d& velocity, Matrix6d& mass, Vector6d& bias) {
      LinkSum sum;
      carrier.immersed.add_to(sum, at, velocity, even);
      sum.write(mass, bias);
    });
  } else {
    each([&](const Carrier& carrier, const PlacedLink& at, const Vector6d& velocity, Matrix6d& mass, Vector6d& bias) {
      add_loads(carrier, at, velocity, around, mass, bias);
    });
  }
  if (is_pushed_) add_pushes(around.world_from_base.transpose());
}

/// Returns true if all links are deep in water that is the same everywhere.
bool ArticulatedBody::is_immersed(const BodyState& base, std::span<const double> positions,
                                  const WaterField& water) const {
  return !has_directions_ && base.world_from_body.position_m.z() + reach_m(positions) < 0 && water.calm_and_even() &&
         water.flows_evenly();
}

double ArticulatedBody::reach_m(std::span<const double> positions) const {
  double reach_m = reach_m_;
  for (const std::size_t k : moving_) {
    if (links_[k].joint == ArmLink::Joint::kSlide) reach_m += std::abs(positions[k]);
  }
  return reach_m;
}

double ArticulatedBody::fastest_m_s(std::span<const double> positions, std::span<const double> speeds) const {
  const double reach_m = this->reach_m(positions);
  double fastest = 0;
  for (const std::size_t k : moving_)
    fastest += std::abs(speeds[k]) * (links_[k].joint == ArmLink::Joint::kSlide ? 1 : reach_m - way_m_[k]);
  return fastest;
}

void ArticulatedBody::add_pushes(const Eigen::Matrix3d& base_from_world) {
  const auto add = [&](const Vector6d& push_world, const Eigen::Vector3d& origin_m, Vector6d& bias) {
    const Eigen::Vector3d force = base_from_world * push_world.head<3>();
    bias.head<3>() -= force;
    bias.tail<3>() -= base_from_world * push_world.tail<3>() + origin_m.cross(force);
  };
  add(pushes_world_[size()], Eigen::Vector3d::Zero(), fixed_.bias);
  for (const std::size_t k : moving_) add(pushes_world_[k], work_[k].placed.origin_m, work_[k].own_bias);
}

void ArticulatedBody::push(std::size_t link, const Vector6d& wrench_world) {
  pushes_world_[carrier_[link] == ArmLink::kBase ? size() : carrier_[link]] += wrench_world;
  is_pushed_ = true;
}

void ArticulatedBody::clear_pushes() {
  if (!is_pushed_) return;
  is_pushed_ = false;
  for (Vector6d& push : pushes_world_) push.setZero();
}

Eigen::Vector3d ArticulatedBody::push_origin_m(std::size_t link) const {
  return carrier_[link] == ArmLink::kBase ? Eigen::Vector3d::Zero() : work_[carrier_[link]].placed.origin_m;
}

/// Viscous friction counts for half a step: Runge-Kutta's answer to a constant force, to second order.
void ArticulatedBody::describe(const Matrix6d& base_mass, double step_s, ContactArm& arm) const {
  const auto index_of = [&](std::uint64_t link) { return link == ArmLink::kBase ? ContactArm::kNone : order_[link]; };
  arm.joints.resize(moving_.size());
  arm.joint_of_link.resize(size());
  for (std::size_t k = 0; k < size(); ++k) arm.joint_of_link[k] = index_of(carrier_[k]);
  Eigen::MatrixXd& mass = arm.mass_factor;
  mass.setZero(arm.size(), arm.size());
  for (const std::size_t k : moving_) composite_[k] = work_[k].mass;
  mass.topLeftCorner<6, 6>() = base_mass + fixed_.inertia;
  for (std::size_t n = moving_.size(); n-- > 0;) {
    const std::size_t k = moving_[n];
    const std::uint64_t parent = joints_[k].parent;
    const auto row = 6 + static_cast<Eigen::Index>(n);
    if (parent == ArmLink::kBase) {
      mass.topLeftCorner<6, 6>() += composite_[k];
    } else {
      composite_[parent] += composite_[k];
    }
    const Vector6d reach = composite_[k] * work_[k].axis;
    mass.row(row).head<6>() = reach;
    mass(row, row) = work_[k].axis.dot(reach) + links_[k].reflected_inertia() + links_[k].viscous_friction * step_s / 2;
    for (std::uint64_t above = parent; above != ArmLink::kBase; above = joints_[above].parent)
      mass(row, 6 + static_cast<Eigen::Index>(order_[above])) = work_[above].axis.dot(reach);
    arm.joints[n].axis = work_[k].axis;
    arm.joints[n].parent = index_of(parent);
  }
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(mass);
}

void ArticulatedBody::add_loads(const Carrier& carrier, const PlacedLink& at, const Vector6d& velocity,
                                const BaseSurroundings& around, Matrix6d& mass, Vector6d& bias) {
  Matrix6d directed_mass;
  Vector6d directed_bias;
  bool is_directed = false;
  LinkSum sum;
  carrier.rigid.add_to(sum, at, velocity, around.gravity_m_s2 * around.world_from_base.row(2).transpose());
  for (const std::size_t link : carrier.links) {
    if (water_[link].has_directions() && !is_directed) {
      directed_mass.setZero();
      directed_bias.setZero();
      is_directed = true;
    }
    weight_n_[link] = links_[link].mass_kg * around.gravity_m_s2;
    lift_n_[link] = water_[link].add_to(sum, directed_mass, directed_bias, at, velocity, around);
  }
  sum.write(mass, bias);
  if (!is_directed) return;
  mass += directed_mass;
  bias += directed_bias;
}

/// Works on numbers rather than on matrices: what is stored one by one and read in pairs waits for the memory.
void ArticulatedBody::place_link(std::size_t k, double position, double speed) {
  const Joint& joint = joints_[k];
  Work& at = work_[k];
  const bool on_base = joint.parent == ArmLink::kBase;
  const bool is_hinge = links_[k].joint == ArmLink::Joint::kHinge;
  const double sine = is_hinge ? std::sin(position) : 0, cosine = is_hinge ? 1 - std::cos(position) : 0;
  const double slid = is_hinge ? 0 : position;
  double r[3][3], o[3], a[3];  // rotation by rows, origin and axis along the base's axes
  const auto turn = [&](int row, int column) {
    return joint.turn(row, column) + sine * joint.by_sine(row, column) + cosine * joint.by_cosine(row, column);
  };
  for (int column = 0; column < 3; ++column) {
    const double x = turn(0, column), y = turn(1, column), z = turn(2, column);
    if (on_base) {
      r[0][column] = x, r[1][column] = y, r[2][column] = z;
      continue;
    }
    const Eigen::Matrix3d& by = work_[joint.parent].placed.base_from_link;
    for (int row = 0; row < 3; ++row) r[row][column] = by(row, 0) * x + by(row, 1) * y + by(row, 2) * z;
  }
  const Eigen::Vector3d mounted_m = joint.origin_m + slid * joint.slide;
  const PlacedLink* const parent = on_base ? nullptr : &work_[joint.parent].placed;
  for (int row = 0; row < 3; ++row) {
    o[row] = on_base
                 ? mounted_m(row)
                 : parent->origin_m(row) + parent->base_from_link(row, 0) * mounted_m(0) +
                       parent->base_from_link(row, 1) * mounted_m(1) + parent->base_from_link(row, 2) * mounted_m(2);
    a[row] = r[row][0] * joint.axis(0) + r[row][1] * joint.axis(1) + r[row][2] * joint.axis(2);
  }
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) at.placed.base_from_link(row, column) = r[row][column];
  }
  const double turning = is_hinge ? speed : 0;
  const Eigen::Vector3d origin_m(o[0], o[1], o[2]), axis(a[0], a[1], a[2]);
  const Eigen::Vector3d along = is_hinge ? Eigen::Vector3d(origin_m.cross(axis)) : axis;
  const Vector6d& moving = on_base ? base_.velocity_body : work_[joint.parent].velocity;
  const Eigen::Vector3d linear = moving.head<3>(), spin = moving.tail<3>();  // of the parent: S x S is zero
  const Eigen::Vector3d moved = speed * along, turned = turning * axis;
  const Eigen::Vector3d linear_rate = spin.cross(moved) + linear.cross(turned), turn_rate = spin.cross(turned);
  at.placed.origin_m = origin_m;
  at.speed = speed;
  for (int n = 0; n < 3; ++n) {
    at.axis(n) = along(n);
    at.axis(n + 3) = is_hinge ? axis(n) : 0;
    at.velocity(n) = linear(n) + moved(n);
    at.velocity(n + 3) = spin(n) + turned(n);
    at.bias_velocity(n) = linear_rate(n);
    at.bias_velocity(n + 3) = turn_rate(n);
  }
}

const ArticulatedBody::Reaction& ArticulatedBody::fold(std::span<const JointDrive> drives) {
  for (const std::size_t k : moving_) {
    work_[k].inertia = work_[k].mass;
    work_[k].bias = work_[k].own_bias;
  }
  reaction_.inertia = fixed_.inertia;
  reaction_.bias = fixed_.bias;
  for (std::size_t n = moving_.size(); n-- > 0;) {
    const std::size_t k = moving_[n];
    Work& at = work_[k];
    const bool on_base = joints_[k].parent == ArmLink::kBase;
    Matrix6d& inertia = on_base ? reaction_.inertia : work_[joints_[k].parent].inertia;
    Vector6d& bias = on_base ? reaction_.bias : work_[joints_[k].parent].bias;
    at.is_given = drives[k].has_acceleration;
    if (at.is_given) {
      inertia += at.inertia;
      at.acceleration = drives[k].value;
      bias += at.bias + at.inertia * (at.bias_velocity + at.acceleration * at.axis);
      continue;
    }
    at.torque = drives[k].value;
    at.reach.noalias() = at.inertia * at.axis;
    at.scale = at.axis.dot(at.reach) + links_[k].reflected_inertia();
    at.force = at.torque - links_[k].viscous_friction * at.speed - at.axis.dot(at.bias);
    const Vector6d share = at.reach / at.scale;
    for (int column = 0; column < 6; ++column)
      inertia.col(column) = inertia.col(column) + at.inertia.col(column) - share(column) * at.reach;
    bias += at.bias + at.inertia * at.bias_velocity + (at.force - at.reach.dot(at.bias_velocity)) * share;
  }
  return reaction_;
}

void ArticulatedBody::unfold(const Vector6d& base_acceleration) {
  for (const std::size_t k : moving_) {
    Work& at = work_[k];
    const std::uint64_t parent = joints_[k].parent;
    at.rate = (parent == ArmLink::kBase ? base_acceleration : work_[parent].rate) + at.bias_velocity;
    if (!at.is_given) at.acceleration = (at.force - at.reach.dot(at.rate)) / at.scale;
    at.rate += at.acceleration * at.axis;
  }
}

double ArticulatedBody::torque(std::size_t k) const {
  const Work& at = work_[k];
  if (carrier_[k] != k) return 0;
  if (!at.is_given) return at.torque;
  return at.axis.dot(at.inertia * at.rate + at.bias) + links_[k].reflected_inertia() * at.acceleration +
         links_[k].viscous_friction * at.speed;
}

Pose ArticulatedBody::world_from_link(std::size_t k) const {
  const PlacedLink at = carrier_[k] == ArmLink::kBase ? in_carrier_[k] : work_[carrier_[k]].placed * in_carrier_[k];
  return base_.world_from_body * Pose{at.origin_m, Eigen::Quaterniond(at.base_from_link).normalized()};
}

Vector6d ArticulatedBody::momentum_base() const {
  Vector6d sum = fixed_.inertia * base_.velocity_body;
  for (const std::size_t k : moving_) sum += work_[k].mass * work_[k].velocity;
  return sum;
}

Matrix6d ArticulatedBody::locked_inertia() const {
  Matrix6d sum = fixed_.inertia;
  for (const std::size_t k : moving_) sum += work_[k].mass;
  return sum;
}

double ArticulatedBody::kinetic_energy_j() const {
  double sum = 0.5 * base_.velocity_body.dot(fixed_.inertia * base_.velocity_body);
  for (const std::size_t k : moving_) {
    const Work& at = work_[k];
    sum += 0.5 * at.velocity.dot(at.mass * at.velocity) + 0.5 * links_[k].reflected_inertia() * at.speed * at.speed;
  }
  return sum;
}

double ArticulatedBody::potential_energy_j() const {
  double sum = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    const Pose at = world_from_link(k);
    sum += weight_n_[k] * at.point(links_[k].centre_of_mass_m).z() -
           lift_n_[k] * at.point(links_[k].centre_of_buoyancy_m).z();
  }
  return sum;
}

}  // namespace uwsim
