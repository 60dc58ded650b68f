#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// Saves and restores the parts of a simulation. Each part lists its values once, in an exchange_state() that both
/// writes them to the archive and reads them back, so saving and restoring cannot disagree. Values are stored
/// without padding, in this machine's representation. Reading throws InvalidValue if the bytes end prematurely or a
/// value is not finite.
class StateArchive {
 public:
  /// Creates an archive for saving.
  StateArchive() = default;
  /// Creates an archive for restoring. `bytes` must outlive it.
  explicit StateArchive(std::string_view bytes) : source_(bytes), restoring_(true) {}

  bool restoring() const { return restoring_; }
  const std::string& bytes() const { return saved_; }

  void operator()(double& value) { numbers({&value, 1}); }
  void operator()(std::uint64_t& value);
  void operator()(bool& value);
  void operator()(Vector6d& value) { numbers({value.data(), 6}); }
  void operator()(std::string& text);
  /// Reading throws unless the orientation is a unit quaternion.
  void operator()(BodyState& state);
  /// Exchanges the length of a list, then calls exchange(item) for each item. An invalid length cannot cause a large
  /// allocation, because memory is allocated only in proportion to the bytes in the archive.
  template <typename List, typename Exchange>
  void list(List& items, const Exchange& exchange) {
    std::uint64_t count = items.size();
    (*this)(count);
    if (restoring_) items.clear();
    for (auto& item : items) exchange(item);
    while (items.size() < count) exchange(items.emplace_back());
  }
  /// Writes `value`. Reading throws unless the archive contains the same value: "state.<what> = 3: must be 2".
  void same(std::string_view what, std::uint64_t value);
  void same(std::string_view what, const std::string& value);
  /// Throws if there are unread bytes left.
  void finish() const;

 private:
  void numbers(std::span<double> values);
  /// Appends `size` bytes from `data`, or reads the next `size` bytes into it.
  void exchange(void* data, std::size_t size);

  std::string saved_;
  std::string_view source_;
  bool restoring_ = false;
};

}  // namespace uwsim
