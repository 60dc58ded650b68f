#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/core/water_field.h"
#include "uwsim/dynamics/block_band.h"
#include "uwsim/dynamics/flow_along.h"
#include "uwsim/dynamics/moved_body.h"
#include "uwsim/dynamics/tether_contact.h"
#include "uwsim/dynamics/tether_spec.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A tether of lumped masses: nodes with half of the mass of the elements beside them, as in MoorDyn (Hall and Goupee
/// 2015, Ocean Engineering 104:590). Elements have axial stiffness and damping in tension only; bending stiffness acts
/// between neighbours; Morison's drag and added mass, weight and buoyancy act on the nodes, as does the bed, with
/// Coulomb friction. Elements touch solids and hulls (TetherContactFinder).
///
/// A step is backward Euler's. With directions, masses and friction's normal forces as at its start, each force is the
/// gradient of a convex potential of the nodes' next positions, so that the step is the minimum of a strictly convex
/// function: it exists at any stiffness, slackness and step, and, with constant masses, energy never grows. Newton's
/// method finds it; each iteration solves a band matrix directly. A body at an end takes part with its full mass: the
/// inverse of its 6 x 6 mass is condensed to the end's point, where the body is a 3 x 3 mass that moves as it would
/// without the tether. What the minimum leaves of that motion is the force on the body, so momentum is exchanged
/// exactly.
///
/// A contact is a plane, frozen in a step, that pushes in proportion to the overlap: so stiff that twice the breaking
/// load, the most that it bears where the tether turns back, overlaps by half of a radius. A hull at it is a
/// mass that gives way, decoupled from its other contacts; what it gains is what the tether loses. Friction is
/// Coulomb's, by the normal force at the step's start, regularized: below kCreep_m_s it grows linearly with the speed
/// (Armstrong-Helouvry et al. 1994, Automatica 30:1083). Both are parts of the same convex function.
///
/// Backward Euler damps: oscillations with angular frequency w by the ratio w dt / 2.
class Tether {
 public:
  /// The bodies' states are those at the start. Throws InvalidValue.
  Tether(const TetherSpec& spec, const World& world, std::span<const MovedBody> bodies);

  const TetherSpec& spec() const { return spec_; }
  bool holds(std::size_t body) const { return spec_.first.body == body || spec_.second.body == body; }
  /// Throws InvalidValue if the ends are farther apart than the tether is long, or it cannot be laid clear of solids.
  void require_reaches(std::span<const MovedBody> bodies, const WaterField& water, double time_s) const;
  /// Lays the tether between its ends again, at rest, and as near to equilibrium as it is unique: a circular arc in a
  /// vertical plane, or another if that meets a solid, that has settled. Throws InvalidValue if each meets a solid.
  void lay(std::span<const MovedBody> bodies, const WaterField& water, double time_s);

  /// Finds the state at the end of a step from `time_s`, and adds the forces at the ends to the bodies' tether_world.
  /// Throws InvalidValue if the motion diverges.
  void step(std::span<MovedBody> bodies, const WaterField& water, double time_s, double step_s);
  /// Replaces what it knows of the bodies' shapes.
  void set_bodies(std::span<const MovedBody> bodies) { finder_.set_bodies(bodies); }
  /// Called after the bodies have moved to their next states.
  void moved(std::span<const MovedBody> bodies, double step_s);

  /// Throws InvalidValue.
  void command(const WinchCommand& command);
  const WinchCommand& winch() const { return winch_; }
  /// Cuts the element at this distance from the first end.
  void cut(double at_m);
  /// From now on it also breaks where the tension exceeds this load, which is not part of the state. Throws
  /// InvalidValue.
  void weaken(double load_n);

  std::size_t elements() const { return nodes_.size() - 1; }
  double length_m() const { return first_m_ + spec_.element_m() * static_cast<double>(elements() - 1); }
  double rate_m_s() const { return rate_m_s_; }  ///< paid out in the last step
  const Eigen::Vector3d& position_m(std::size_t node) const { return nodes_[node].position; }
  const Eigen::Vector3d& velocity_m_s(std::size_t node) const { return nodes_[node].velocity; }
  double tension_n(std::size_t element) const { return nodes_[element].tension_n; }
  double rest_m(std::size_t element) const { return element == 0 ? first_m_ : spec_.element_m(); }
  double mass_kg(std::size_t node) const { return spec_.mass_kg_m * span_m(node); }
  /// Where it touches solids and hulls, or may, in the last step.
  std::span<const TetherContact> contacts() const { return contacts_; }
  /// The force of the tether on what holds its first (0) and its second end (1), world axes, in the last step.
  const Eigen::Vector3d& end_force_n(std::size_t end) const { return end_forces_.at(end); }
  /// The element that has broken, counted from the first end.
  std::optional<std::size_t> broken() const;

  /// Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  struct Node {
    Eigen::Vector3d position, velocity;
    Eigen::Vector3d grip;  // where friction holds it
    double tension_n = 0;  // of the element after it
  };
  struct Pull {
    double tension, stiffness;
  };
  /// The weights of a node and its neighbours in what half of whose square is the energy of bending.
  struct Bending {
    double before, here, after;
  };
  /// Constant within a step; and of the element after a node, its pull in the present iteration.
  struct Frozen {
    Eigen::Vector3d target, force, flow, tangent;
    double normal_mass, tangential_mass, normal_drag, tangential_drag;
    Eigen::Matrix3d inertia;  // mass per squared step
    Eigen::Vector3d bed_normal;
    double bed_level_m, bed_stiffness, friction_n;
    bool is_on_bed = false, slides = false;  // in the present iteration
    // The element after it, at the start of the step and in the present iteration:
    double stretch_m, tension_n, stiffness, damping;
    Eigen::Vector3d unit;
    Pull pull;
  };
  /// An end in a step: one that moves whatever pulls it, if at all, or a mass that moves.
  struct End {
    bool is_fixed = true, turns_back = false;
    Eigen::Vector3d next = Eigen::Vector3d::Zero();  // without the tether's force
    Eigen::Matrix3d mass = Eigen::Matrix3d::Zero();
    // its body:
    Eigen::Vector3d free_next = Eigen::Vector3d::Zero(), free_turn_body = Eigen::Vector3d::Zero();
    Eigen::Vector3d lever_body_m = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
    Matrix6d inverse_mass = Matrix6d::Zero();
    Eigen::Matrix3d body_from_world = Eigen::Matrix3d::Zero();
    // turn_back():
    Eigen::Vector3d force_body_n = Eigen::Vector3d::Zero(), turn_body = Eigen::Vector3d::Zero();
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero(), turn_per_n = Eigen::Matrix3d::Zero();

    /// By which the torque changes as the body turns.
    Eigen::Vector3d torque_body(const Eigen::Vector3d& force_n, double step_s) const {
      return -step_s * (stiffness * (turn_body + turn_per_n * force_n));
    }
  };
  /// How long the first element may become in a step, and the tension at which it does.
  struct Drum {
    double low_m, high_m, tension_n;
  };

  /// The nodes as a line, at the start of the step: for the flow, and for the search for contacts.
  struct Line {
    std::vector<Eigen::Vector3d> points, targets;  // where they are, and where they would go without contacts
    std::vector<double> along_m, half_heights_m;   // from the first node; of the part that a node stands for
    std::vector<double> reach_m;                   // of an element: how far contacts are looked for
    void resize(std::size_t most);
  };
  /// For the nodes' next positions, where Newton's method alone fails.
  struct Search {
    std::vector<Eigen::Vector3d> found;      // with the last stiffness
    std::vector<Eigen::Vector3d> from, way;  // of a line search
    void resize(std::size_t most);
  };

  double span_m(std::size_t node) const;
  Eigen::Vector3d end_point(const TetherEnd& end, std::span<const MovedBody> bodies) const;
  End end_of(const TetherEnd& end, std::span<MovedBody> bodies, const WaterField& water, double time_s,
             double step_s) const;
  static bool turn_back(End& end, const Eigen::Vector3d& force_n, double step_s);
  void freeze(const WaterField& water, double time_s, double step_s);
  void freeze_water(std::size_t node, const WaterField& water, double step_s);
  void freeze_bed(std::size_t node);
  void freeze_contacts(std::span<const MovedBody> bodies, double step_s, double least_reach_m, double moving_s);
  void freeze_contact(TetherContact& contact, double step_s);
  void yield_hulls(std::span<const MovedBody> bodies, const WaterField& water, double time_s, double step_s);
  void add_contacts(bool with_hessian);
  void press_contacts();
  void push_hulls(std::span<MovedBody> bodies);
  static Eigen::Vector3d place(const std::vector<Eigen::Vector3d>& nodes, const TetherContact& contact);
  std::string first_crossed() const;
  bool crosses_cover() const;
  bool may_meet_solids(const Eigen::Vector3d& first, const Eigen::Vector3d& second) const;
  void require_length(std::span<const MovedBody> bodies) const;
  void lay_arc(const Eigen::Vector3d& start, const Eigen::Vector3d& between, const Eigen::Vector3d& sag);
  Drum drum(double step_s) const;
  bool find_next(double step_s);
  void begin_search(double share);
  bool solve(double step_s);
  double find_change(double step_s);
  bool stiffen(double step_s);
  bool descend(double step_s);
  double search_line(double step_s, double start, double most);
  void limit_energy(double step_s);
  void be_consistent();
  void find_stiffness(double share, double step_s);
  void find_end_forces(double step_s);
  double find_change_again(double step_s);
  double solve_factored();
  void solve_band(std::vector<Eigen::Vector3d>& x) const;
  bool refine(double step_s, double last_m);
  void take(double share);
  void assemble(double step_s, bool with_hessian = true);
  void add_node(std::size_t node, double step_s, bool with_hessian);
  void add_element(std::size_t element, double step_s, bool with_hessian);
  void add_bending(std::size_t node, const Bending& bending, bool with_hessian);
  Bending bending(std::size_t node) const;
  void add_ends(double step_s, bool with_hessian);
  Pull pull(std::size_t element, double distance_m, double step_s) const;
  static Pull taut(const Frozen& element, double stretch_m);
  static Eigen::Vector3d scaled(const Eigen::Vector3d& v, const Eigen::Vector3d& unit, double along, double across);
  void settle(std::span<const MovedBody> bodies, const WaterField& water, double time_s);
  void wind(double step_s);
  void grip(std::size_t node);
  void break_if_overloaded();

  TetherSpec spec_;
  std::shared_ptr<const Heightfield> terrain_;
  TetherContactFinder finder_;
  bool is_stiff_;
  // The state.
  std::vector<Node> nodes_;
  double first_m_ = 0;  // rest length of the first element
  double rate_m_s_ = 0;
  double weakened_n_ = std::numeric_limits<double>::infinity();
  std::uint64_t broken_ = kWhole;
  WinchCommand winch_;
  std::array<Eigen::Vector3d, 2> end_forces_;
  // The step under way. Kept so that steps allocate nothing.
  static constexpr std::uint64_t kWhole = std::numeric_limits<std::uint64_t>::max();
  std::vector<Frozen> frozen_;
  std::vector<Eigen::Vector3d> next_, gradient_, change_;
  Search search_;
  BlockBand hessian_;
  std::vector<TetherContact> contacts_;
  Line line_;
  FlowAlong flow_;
  std::array<End, 2> ends_;
  bool is_same_ = false;  // what presses and pulls, as when the Hessian was found
  Drum drum_{};
  std::array<Eigen::Matrix3d, 2> end_next_;  // off the rows that fixed ends remove
  std::array<double, 2> end_second_{};
  std::array<Eigen::Vector3d, 2> end_gradient_;
};

}  // namespace uwsim
