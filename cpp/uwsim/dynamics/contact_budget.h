#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <stdexcept>

namespace uwsim {

/// Thrown if the search for a body's contacts would not finish in reasonable time. what() reports the counts and the
/// likely cause.
class ContactBudgetExceeded : public std::runtime_error {
 public:
  ContactBudgetExceeded(std::size_t body, const std::string& message) : std::runtime_error(message), body(body) {}
  std::size_t body;
};

/// Limits the cost of one body's contact search in a step, counted in tests of one feature against another (about 10 ns
/// each). A hull given in millimetres by mistake, and thus a thousand times too large for the terrain's cells, is
/// refused at the same step on every machine instead of being searched for hours.
class ContactBudget {
 public:
  /// About a second on one core, and about a hundred times the cost of a vehicle on a bed with a 5 cm grid
  static constexpr std::size_t kMostTests = 300'000'000;
  /// Building and storing one triangle; the budget allows a million triangles
  static constexpr std::size_t kTestsPerTriangle = 300;
  /// One overlap test of convex shapes with GJK and EPA, about 30 us
  static constexpr std::size_t kTestsPerOverlap = 3'000;

  /// Starts the search for a body. size_m: the size of its shape, for the error message.
  void begin(std::size_t body, const Eigen::Vector3d& size_m);
  /// Throws ContactBudgetExceeded if the limit is exceeded.
  void spend(std::size_t tests) {
    spent_ += tests;
    if (spent_ > kMostTests) refuse();
  }
  void spend_on_triangles(std::size_t count) {
    triangles_ += count;
    spend(kTestsPerTriangle * count);
  }
  /// The number of triangles that still fit in the budget.
  std::size_t triangles_left() const { return (kMostTests - spent_) / kTestsPerTriangle; }
  std::size_t spent() const { return spent_; }

 private:
  [[noreturn]] void refuse() const;

  std::size_t body_ = 0, spent_ = 0, triangles_ = 0;
  Eigen::Vector3d size_m_ = Eigen::Vector3d::Zero();
};

}  // namespace uwsim
