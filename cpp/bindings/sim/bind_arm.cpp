#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/convert.h"
#include "bindings/core/record.h"
#include "bindings/sim/binders.h"
#include "uwsim/core/check.h"
#include "uwsim/dynamics/spatial.h"

namespace uwsim::bindings {
namespace {

using Doubles = std::vector<double>;

/// An arm's joints as they are.
struct ArmReading {
  std::vector<std::string> names;
  Eigen::VectorXd positions, speeds, motor_torques, currents_a;
};

ArmReading arm_reading(const Arm& arm) {
  const auto count = static_cast<Eigen::Index>(arm.size());
  ArmReading now{{}, Eigen::VectorXd(count), Eigen::VectorXd(count), Eigen::VectorXd(count), Eigen::VectorXd(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto joint = static_cast<std::size_t>(k);
    const ArmLink& link = arm.links()[joint];
    now.names.push_back(link.name);
    now.positions(k) = arm.position(joint);
    now.speeds(k) = arm.speed(joint);
    now.motor_torques(k) = arm.motor_torque(joint);
    now.currents_a(k) = arm.motor_torque(joint) / link.torque_per_ampere;  // NaN or infinite if that is unknown
    if (link.torque_per_ampere == 0) now.currents_a(k) = std::numeric_limits<double>::quiet_NaN();
  }
  return now;
}

JointCommand joint_command(std::optional<double> position, std::optional<double> speed, std::optional<double> torque) {
  const int given = (position ? 1 : 0) + (speed ? 1 : 0) + (torque ? 1 : 0);
  require(given == 1, "joint command", given, "must be one of position, speed and torque");
  using Mode = JointCommand::Mode;
  if (position) return {Mode::kPosition, *position};
  return speed ? JointCommand{Mode::kSpeed, *speed} : JointCommand{Mode::kTorque, *torque};
}

using JointValues = Actuators::Named;

std::size_t joint_named(const Arm& arm, const std::string& name) {
  for (std::size_t k = 0; k < arm.size(); ++k) {
    if (arm.links()[k].name == name) return k;
  }
  require(false, "joint", name, "must be a joint of the arm");
  return 0;
}

void command_arm(Arm& arm, const JointValues& positions, const JointValues& speeds, const JointValues& torques) {
  using Mode = JointCommand::Mode;
  for (const auto& [mode, all] :
       {std::pair(Mode::kPosition, &positions), {Mode::kSpeed, &speeds}, {Mode::kTorque, &torques}}) {
    for (const auto& [name, value] : *all) arm.command(joint_named(arm, name), {mode, value});
  }
}

/// A rigid base in no water, on which a wrench acts that is constant along the world's axes.
class FreeBase final : public ArmBase {
 public:
  FreeBase(const Matrix6d& mass, const Vector6d& wrench_world) : mass_(mass), wrench_world_(wrench_world) {}
  Load at(const BodyState& state, double) const override {
    const Vector6d& v = state.velocity_body;
    return {mass_, in_body_axes(wrench_world_, state.world_from_body.orientation) - cross_force(v, mass_ * v)};
  }

 private:
  Matrix6d mass_;
  Vector6d wrench_world_;
};

/// An arm on a base of its own.
struct Mechanism {
  Arm arm;
  ArticulatedBody body;
  double step_s;
  std::optional<Matrix6d> base_mass;
  BodyState base;

  Mechanism(const std::vector<ArmLink>& links, double step, const std::optional<Matrix6d>& mass)
      : arm(links, step), body(links), step_s(step), base_mass(mass) {}

  std::pair<Vector6d, Doubles> accelerations(const Doubles& torques, const Water& water, const Vector6d& wrench_world) {
    require(torques.size() == arm.size(), "torques", torques.size(), "must be one for each link");
    Doubles positions, speeds, found;
    std::vector<JointDrive> drives;
    for (std::size_t k = 0; k < arm.size(); ++k) {
      positions.push_back(arm.position(k));
      speeds.push_back(arm.speed(k));
      drives.push_back({false, torques[k]});
    }
    body.place(base, positions, speeds, water, 0);
    const ArticulatedBody::Reaction reaction = body.fold(drives);
    Vector6d acceleration = Vector6d::Zero();
    if (base_mass) {
      const ArmBase::Load load = FreeBase(*base_mass, wrench_world).at(base, 0);
      acceleration = (load.mass + reaction.inertia).ldlt().solve(load.wrench - reaction.bias);
    }
    body.unfold(acceleration);
    for (std::size_t k = 0; k < arm.size(); ++k) found.push_back(body.acceleration(k));
    return {acceleration, found};
  }

  void step(std::uint64_t count, const Water& water, const Vector6d& wrench_world) {
    for (std::uint64_t k = 0; k < count; ++k) {
      arm.begin();
      if (base_mass) {
        base = arm.advance(FreeBase(*base_mass, wrench_world), base, water, 0, step_s);
      } else {
        arm.advance(HeldBase(), base, water, 0, step_s);
      }
      arm.require_plausible("mechanism", "arm");
      arm.accept();
    }
  }
};

void bind_mechanism(py::module_& m) {
  py::class_<Mechanism>(m, "Mechanism",
                        "An articulated body on a base of its own: fixed, or a rigid body. For studies; a vehicle's\n"
                        "arm is part of its file. Featherstone's articulated-body algorithm, see the page on theory.")
      .def(py::init<const std::vector<ArmLink>&, double, const std::optional<Matrix6d>&>(), py::arg("links"),
           py::arg("step_s") = 0.001, py::arg("base_mass") = py::none(),
           "base_mass: (6, 6) of the base about its origin, linear before angular [kg, kg m, kg m^2]; None: fixed.")
      .def_readwrite("base", &Mechanism::base, "the base's BodyState")
      .def(
          "place", [](Mechanism& o, std::size_t k, double position, double speed) { o.arm.place(k, position, speed); },
          py::arg("joint"), py::arg("position"), py::arg("speed") = 0.0)
      .def(
          "command",
          [](Mechanism& o, std::size_t k, std::optional<double> position, std::optional<double> speed,
             std::optional<double> torque) { o.arm.command(k, joint_command(position, speed, torque)); },
          py::arg("joint"), py::arg("position") = py::none(), py::arg("speed") = py::none(),
          py::arg("torque") = py::none())
      .def("reading", [](const Mechanism& o) { return arm_reading(o.arm); })
      .def("accelerations", &Mechanism::accelerations, py::arg("torques"), py::arg("water"),
           py::arg("wrench_world") = Vector6d(Vector6d::Zero()),
           "Return nu' of the base, (6,), and the joints' accelerations under these torques, without Coulomb friction\n"
           "and stops. wrench_world: (6,) on the base at its origin, along the world's axes [N, N m].")
      .def("step", &Mechanism::step, py::arg("count"), py::arg("water"),
           py::arg("wrench_world") = Vector6d(Vector6d::Zero()), "Advance by fixed steps.")
      .def(
          "energy_j",
          [](Mechanism& o, const Water& water) {
            const ArticulatedBody& placed = o.arm.placed(o.base, water, 0);
            const Vector6d& v = o.base.velocity_body;
            const double base = o.base_mass ? 0.5 * v.dot(*o.base_mass * v) : 0;
            return std::pair(base + placed.kinetic_energy_j(), placed.potential_energy_j());
          },
          py::arg("water"), "Return kinetic energy, and that of the links' height [J].")
      .def(
          "momentum_base",
          [](Mechanism& o, const Water& water) {
            Vector6d sum = o.arm.placed(o.base, water, 0).momentum_base();
            if (o.base_mass) sum += *o.base_mass * o.base.velocity_body;
            return sum;
          },
          py::arg("water"), "Return the momentum at the base's origin along its axes, (6,).")
      .def(
          "reaction_base", [](const Mechanism& o) { return Vector6d(o.arm.stage_wrenches()[0]); },
          "Return the wrench of the links on the base at the start of the last step, along its axes, (6,).")
      .def(
          "world_from_link",
          [](Mechanism& o, std::size_t k, const Water& water) {
            return o.arm.placed(o.base, water, 0).world_from_link(k).matrix();
          },
          py::arg("link"), py::arg("water"));
}

Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> rows(const std::vector<Pose>& poses) {
  Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> found(poses.size(), 7);
  for (std::size_t k = 0; k < poses.size(); ++k)
    found.row(static_cast<Eigen::Index>(k)) << poses[k].position_m.transpose(),
        poses[k].orientation.coeffs().transpose();
  return found;
}

}  // namespace

void bind_arm_link(py::module_& m) {
  py::enum_<ArmLink::Joint>(m, "JointKind")
      .value("FIXED", ArmLink::Joint::kFixed)
      .value("HINGE", ArmLink::Joint::kHinge)
      .value("SLIDE", ArmLink::Joint::kSlide);
  py::class_<ArmLink>(m, "ArmLink", "A link of an arm, and the joint that holds it.")
      .def(py::init<>())
      .def_readwrite("name", &ArmLink::name)
      .def_property(
          "parent",
          [](const ArmLink& link) {
            return link.parent == ArmLink::kBase ? std::nullopt : std::optional<std::uint64_t>(link.parent);
          },
          [](ArmLink& link, std::optional<std::uint64_t> parent) { link.parent = parent.value_or(ArmLink::kBase); },
          "index of an earlier link; None: the base")
      .def_readwrite("joint", &ArmLink::joint)
      .def(
          "set_pose",
          [](ArmLink& link, const py::object& position_m, const py::object& orientation_xyzw) {
            link.parent_from_link = as_pose(position_m, orientation_xyzw, "link");
          },
          py::arg("position_m"), py::arg("orientation_xyzw"), "Set the link's frame in its parent's, at zero.")
      .def_readwrite("axis", &ArmLink::axis)
      .def_readwrite("mass_kg", &ArmLink::mass_kg)
      .def_readwrite("centre_of_mass_m", &ArmLink::centre_of_mass_m)
      .def_readwrite("inertia_kg_m2", &ArmLink::inertia_kg_m2, "(3, 3), about the centre of mass")
      .def_readwrite("volume_m3", &ArmLink::volume_m3)
      .def_readwrite("centre_of_buoyancy_m", &ArmLink::centre_of_buoyancy_m)
      .def_readwrite("added_mass", &ArmLink::added_mass, "(6, 6), at the link's origin")
      .def_readwrite("linear_drag", &ArmLink::linear_drag, "(6,), at the centre of buoyancy")
      .def_readwrite("quadratic_drag", &ArmLink::quadratic_drag, "(6,), at the centre of buoyancy")
      .def(
          "set_surface",
          [](ArmLink& link, const py::object& vertices_m, const py::object& triangles) {
            link.surface_m = std::make_shared<const TriangleMesh>(
                TriangleMesh{as_points(vertices_m, "vertices_m"), as_triangles(triangles, "triangles")});
          },
          py::arg("vertices_m"), py::arg("triangles"),
          "Set what light and sound meet: a closed mesh in the link's frame, (n, 3) and (m, 3).")
      .def_readwrite("start", &ArmLink::start)
      .def_readwrite("lowest", &ArmLink::lowest)
      .def_readwrite("highest", &ArmLink::highest)
      .def_readwrite("friction", &ArmLink::friction)
      .def_readwrite("viscous_friction", &ArmLink::viscous_friction)
      .def_readwrite("coulomb_friction", &ArmLink::coulomb_friction)
      .def_readwrite("gear_ratio", &ArmLink::gear_ratio)
      .def_readwrite("rotor_inertia_kg_m2", &ArmLink::rotor_inertia_kg_m2)
      .def_readwrite("strongest", &ArmLink::strongest, "of the motor, at the joint; 0: there is none")
      .def_readwrite("fastest", &ArmLink::fastest)
      .def_readwrite("response_s", &ArmLink::response_s)
      .def_readwrite("torque_per_ampere", &ArmLink::torque_per_ampere, "0: unknown");
  Record<ArmReading>(m, "ArmReading", "The joints of an arm; those that are fixed stay at zero.")
      .field("names", &ArmReading::names)
      .field("positions", &ArmReading::positions, "(n,) [rad or m]")
      .field("speeds", &ArmReading::speeds, "(n,) [rad/s or m/s]")
      .field("motor_torques", &ArmReading::motor_torques, "(n,), at the joints [N m or N]")
      .field("currents_a", &ArmReading::currents_a, "(n,); NaN where it is unknown")
      .done();
  bind_mechanism(m);
}

void bind_arm(py::module_&, py::class_<OwnedSimulation>& simulation) {
  simulation
      .def(
          "arm",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with_briefly([&](Simulation& s) { return arm_reading(s.arm(v)); });
          },
          py::arg("body"),
          "Return the arm's ArmReading: of a vehicle or, after those, of an object. Raises ValueError.")
      .def(
          "link_surfaces",
          [](OwnedSimulation& o) { return rows(o.with_briefly([](Simulation& s) { return s.link_surfaces(); })); },
          "Return where the links are that have a surface, of all vehicles in order: (n, 7), position [m] and\n"
          "quaternion x, y, z, w in the world.")
      .def(
          "attached_surfaces",
          [](OwnedSimulation& o) { return rows(o.with_briefly([](Simulation& s) { return s.attached_surfaces(); })); },
          "Return those of links, and then where the tubes of all tethers are, (n, 7).")
      .def(
          "place_joint",
          [](OwnedSimulation& o, std::size_t v, std::size_t joint, double position, double speed) {
            o.with([&](Simulation& s) { s.arm(v).place(joint, position, speed); });
          },
          py::arg("vehicle"), py::arg("joint"), py::arg("position"), py::arg("speed") = 0.0,
          "Move a joint immediately. Raises ValueError.")
      .def(
          "links_world",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with([&](Simulation& s) {
              std::vector<Eigen::Matrix4d> poses;
              const ArticulatedBody& placed = s.arm(v).placed(s.body_state(v), s.water(), s.time_s());
              for (std::size_t k = 0; k < placed.size(); ++k) poses.push_back(placed.world_from_link(k).matrix());
              return poses;
            });
          },
          py::arg("body"), "Return world_from_link of each link, (4, 4), as for `arm`.")
      .def(
          "command_joints",
          [](OwnedSimulation& o, std::size_t v, const JointValues& positions, const JointValues& speeds,
             const JointValues& torques) {
            o.with_briefly([&](Simulation& s) {
              Arm& arm = s.arm(v);
              Arm trial = arm;  // so that an error changes nothing
              for (Arm* each : {&trial, &arm}) command_arm(*each, positions, speeds, torques);
            });
          },
          py::arg("vehicle"), py::arg("positions"), py::arg("speeds"), py::arg("torques"),
          "Command joints from (name, value) pairs: positions [rad or m], speeds [per s], the motors' torques at the\n"
          "joints [N m or N]. The others keep their commands. Raises ValueError, changing nothing.");
}

}  // namespace uwsim::bindings
