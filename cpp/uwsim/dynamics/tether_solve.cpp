#include <algorithm>
#include <cmath>

#include "uwsim/dynamics/tether.h"

// The part of Tether that finds the nodes' next positions, the minimum of a convex function.
namespace uwsim {
namespace {

constexpr int kIterations = 40;
constexpr int kFull = 12;           // iterations after which changes are halved, in case that they alternate
constexpr double kSolved_m = 1e-7;  // the change of an iteration after which positions are found
// Changes with the Hessian of the last iteration, which are cheaper, follow while each is less than this part of the
// one before. Positions are found where the next such change would be as small as this.
constexpr double kShrinking = 0.1, kPredicted_m = 1e-9;
constexpr int kRefinements = 4;
constexpr double kLost_m = 1e6;  // the change after which they are not
// Otherwise the tether is made as soft as its nodes' inertia in a step, and then stiffer by stages.
constexpr double kStiffer = 5;
constexpr int kDescents = 60;
constexpr double kEnough = 0.5;  // a line search ends where the slope is this part of that at its start
constexpr int kBisections = 50;

}  // namespace

/// Newton's method for positions and tensions. Tensions are unknowns of their own, which each iteration eliminates, so
/// that its convergence does not depend on the stiffness once it is near. Where it does not converge, a softer tether's
/// positions are found first, whose stiffness then grows, with line searches; the last that are found are taken as far
/// as energy allows. Returns whether it has converged at the full stiffness.
bool Tether::find_next(double step_s) {
  begin_search(1);
  bool is_solved = solve(step_s);
  if (!is_solved) {
    is_solved = stiffen(step_s);
    if (!is_solved) limit_energy(step_s);
    be_consistent();
    assemble(step_s);
    std::ranges::fill(change_, Eigen::Vector3d::Zero());
    press_contacts();
  }
  find_end_forces(step_s);
  return is_solved;
}

/// Begins where the nodes would go, with the tensions of the last step times `share`.
void Tether::begin_search(double share) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    next_[i] = frozen_[i].target;
    frozen_[i].tension_n = share * nodes_[i].tension_n;
  }
  next_.front() = ends_[0].next;
  next_[elements()] = ends_[1].next;
}

bool Tether::solve(double step_s) {
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double share = iteration < kFull ? 1 : 0.5;
    const double largest = find_change(step_s);
    take(share);
    if (largest <= kSolved_m) return true;
    if (!(largest < kLost_m)) return false;
    if (iteration < kFull && refine(step_s, largest)) return true;
  }
  return false;
}

/// Takes a share of an iteration's change, and the forces that follow from it.
void Tether::take(double share) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) next_[i] += share * change_[i];
  for (std::size_t i = 0; i < elements(); ++i) {
    Frozen& f = frozen_[i];
    f.tension_n = std::max(0.0, f.pull.tension + f.pull.stiffness * f.unit.dot(change_[i + 1] - change_[i]));
  }
  press_contacts();
}

/// Simplified Newton iterations (Hairer and Wanner 1996, "Solving Ordinary Differential Equations II", IV.8), after a
/// change of `last_m` and while the same elements pull and the same contacts press. Returns whether positions are
/// found.
bool Tether::refine(double step_s, double last_m) {
  for (int k = 0; k < kRefinements; ++k) {
    const double largest = find_change_again(step_s);
    if (!is_same_ || !(largest < kShrinking * last_m)) return false;
    take(1);
    if (largest * largest <= kPredicted_m * last_m) return true;
    last_m = largest;
  }
  return false;
}

/// Newton's change from next_; returns its largest component.
double Tether::find_change(double step_s) {
  const std::size_t rows = nodes_.size();
  assemble(step_s);
  if (is_stiff_) {
    hessian_.factor_stiff(rows);
  } else {
    hessian_.factor(rows);
  }
  return solve_factored();
}

/// The same with the Hessian of the last find_change().
double Tether::find_change_again(double step_s) {
  assemble(step_s, false);
  return solve_factored();
}

void Tether::solve_band(std::vector<Eigen::Vector3d>& x) const {
  if (is_stiff_) {
    hessian_.solve_stiff(nodes_.size(), x);
  } else {
    hessian_.solve(nodes_.size(), x);
  }
}

double Tether::solve_factored() {
  const std::size_t rows = nodes_.size();
  for (std::size_t i = 0; i < rows; ++i) change_[i] = -gradient_[i];
  solve_band(change_);
  double largest = 0;
  for (std::size_t i = 0; i < rows; ++i) largest = std::max(largest, change_[i].cwiseAbs().maxCoeff());
  return largest;
}

bool Tether::stiffen(double step_s) {
  const double inertia = mass_kg(elements() / 2) / (step_s * step_s) * spec_.element_m();
  double share = std::min(1.0, inertia / (spec_.axial_stiffness_n + spec_.axial_damping_n_s / step_s));
  begin_search(share);
  bool is_solved = false;
  while (true) {
    find_stiffness(share, step_s);
    std::copy_n(next_.begin(), nodes_.size(), search_.found.begin());
    is_solved = solve(step_s);
    if (!is_solved) {
      std::copy_n(search_.found.begin(), nodes_.size(), next_.begin());
      is_solved = descend(step_s);
    }
    if (!is_solved || share == 1) break;
    share = std::min(1.0, kStiffer * share);
  }
  find_stiffness(1, step_s);
  return is_solved;
}

/// That of the elements, times `share`.
void Tether::find_stiffness(double share, double step_s) {
  for (std::size_t i = 0; i < elements(); ++i) {
    Frozen& f = frozen_[i];
    f.damping = share * spec_.axial_damping_n_s / (rest_m(i) * step_s);
    f.stiffness = share * spec_.axial_stiffness_n / rest_m(i) + f.damping;
  }
}

/// Newton's method with line searches.
bool Tether::descend(double step_s) {
  const std::size_t rows = nodes_.size();
  for (int iteration = 0; iteration < kDescents; ++iteration) {
    be_consistent();
    const double largest = find_change(step_s);
    if (!(largest < kLost_m)) return false;
    std::copy_n(next_.begin(), rows, search_.from.begin());
    std::copy_n(change_.begin(), rows, search_.way.begin());
    double start = 0;
    for (std::size_t i = 0; i < rows; ++i) start += gradient_[i].dot(search_.way[i]);
    const double share = search_line(step_s, start, -kEnough * start);
    if (share * largest <= kSolved_m) return largest <= kSolved_m;
  }
  return false;
}

/// Moves from search_.from along search_.way, on which the function's slope grows, as it is convex: all the way, or to
/// where the slope is at most `most`. Returns the share of the way.
double Tether::search_line(double step_s, double start, double most) {
  const std::size_t rows = nodes_.size();
  const auto slope = [&](double share) {
    for (std::size_t i = 0; i < rows; ++i) next_[i] = search_.from[i] + share * search_.way[i];
    be_consistent();
    assemble(step_s, false);
    double sum = 0;
    for (std::size_t i = 0; i < rows; ++i) sum += gradient_[i].dot(search_.way[i]);
    return sum;
  };
  double low = 0, high = 1;
  if (slope(1) <= most) return 1;
  for (int cut = 0; cut < kBisections; ++cut) {
    const double middle = (low + high) / 2, here = slope(middle);
    (here <= most ? low : high) = middle;
    if (here <= most && here >= kEnough * start) break;
  }
  for (std::size_t i = 0; i < rows; ++i) next_[i] = search_.from[i] + low * search_.way[i];
  return low;
}

/// Goes from where the nodes are towards next_ as long as that lowers the function. There, the change's power is that
/// of a step of backward Euler's along it, in which energy never grows.
void Tether::limit_energy(double step_s) {
  const std::size_t rows = nodes_.size();
  for (std::size_t i = 0; i < rows; ++i) {
    search_.from[i] = line_.points[i];
    search_.way[i] = next_[i] - line_.points[i];
  }
  search_line(step_s, -std::numeric_limits<double>::infinity(), 0);
}

/// The forces of the tether on what holds it.
void Tether::find_end_forces(double step_s) {
  const double per_s2 = 1 / (step_s * step_s);
  const std::size_t rows = nodes_.size();
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t row = k == 0 ? 0 : rows - 1, one = k == 0 ? 1 : rows - 2, two = k == 0 ? 2 : rows - 3;
    if (!ends_[k].is_fixed) {
      end_forces_[k] = per_s2 * ends_[k].mass * (next_[row] - ends_[k].next);
      continue;
    }
    end_forces_[k] =
        -end_gradient_[k] - (k == 0 ? end_next_[k] : Eigen::Matrix3d(end_next_[k].transpose())) * change_[one];
    if (rows > 2) end_forces_[k] -= end_second_[k] * change_[two];
  }
}

}  // namespace uwsim
