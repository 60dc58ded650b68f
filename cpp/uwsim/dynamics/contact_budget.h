#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <stdexcept>

namespace uwsim {

/// A body's search for contacts that would not end in reasonable time; what() has the numbers and what to look for.
class ContactBudgetExceeded : public std::runtime_error {
 public:
  ContactBudgetExceeded(std::size_t body, const std::string& message) : std::runtime_error(message), body(body) {}
  std::size_t body;
};

/// What the search for one body's contacts may cost in a step, counted in tests of one feature against another, some 10
/// ns each. So a hull in millimetres among a thousand times smaller cells is refused by its numbers, on every machine
/// at the same step, instead of searching for hours.
class ContactBudget {
 public:
  /// About a second of one core, and some hundred times what a vehicle on a fine bed of 5 cm takes.
  static constexpr std::size_t kMostTests = 300'000'000;
  static constexpr std::size_t kTestsPerTriangle = 300;   ///< to make a triangle, and for its memory: a million fit
  static constexpr std::size_t kTestsPerOverlap = 3'000;  ///< an overlap of convex shapes by GJK and EPA, some 30 us

  /// Begins the search for a body. size_m: of its shape, for the message.
  void begin(std::size_t body, const Eigen::Vector3d& size_m);
  /// Throws ContactBudgetExceeded when more was spent than may be.
  void spend(std::size_t tests) {
    spent_ += tests;
    if (spent_ > kMostTests) refuse();
  }
  void spend_on_triangles(std::size_t count) {
    triangles_ += count;
    spend(kTestsPerTriangle * count);
  }
  /// How many triangles can still be afforded.
  std::size_t triangles_left() const { return (kMostTests - spent_) / kTestsPerTriangle; }
  std::size_t spent() const { return spent_; }

 private:
  [[noreturn]] void refuse() const;

  std::size_t body_ = 0, spent_ = 0, triangles_ = 0;
  Eigen::Vector3d size_m_ = Eigen::Vector3d::Zero();
};

}  // namespace uwsim
