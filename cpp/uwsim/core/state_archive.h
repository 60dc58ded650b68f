#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// What a simulation's parts save and restore themselves through: each lists its figures once, in one function that
/// writes them or takes them back, so that the two cannot differ. Figures lie one after the other as this machine holds
/// them. Throws InvalidValue when what is read ends early, or a figure is not finite.
class StateArchive {
 public:
  /// Saves.
  StateArchive() = default;
  /// Restores from `bytes`, which must outlive it.
  explicit StateArchive(std::string_view bytes) : source_(bytes), restoring_(true) {}

  bool restoring() const { return restoring_; }
  const std::string& bytes() const { return saved_; }

  void operator()(double& value) { numbers({&value, 1}); }
  void operator()(std::uint64_t& value);
  void operator()(bool& value);
  void operator()(Vector6d& value) { numbers({value.data(), 6}); }
  void operator()(std::string& text);
  /// Throws when the orientation that is read is none.
  void operator()(BodyState& state);
  /// Writes `value`; what is read must be the same, or throws: "state.<what> = 3: must be 2".
  void same(std::string_view what, std::uint64_t value);
  void same(std::string_view what, const std::string& value);
  /// Throws when something is left to read.
  void finish() const;

 private:
  void numbers(std::span<double> values);
  /// The next bytes to read, or room to write.
  void exchange(void* data, std::size_t size);

  std::string saved_;
  std::string_view source_;
  bool restoring_ = false;
};

}  // namespace uwsim
