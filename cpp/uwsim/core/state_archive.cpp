#include "uwsim/core/state_archive.h"

#include <cmath>
#include <cstring>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

// Tolerance for a quaternion's length; simulation steps change the length only by rounding
constexpr double kUnitTolerance = 1e-6;

}  // namespace

void StateArchive::exchange(void* data, std::size_t size) {
  if (!restoring_) {
    saved_.append(static_cast<const char*>(data), size);
    return;
  }
  require(size <= source_.size(), "state", "truncated", "must be as long as it was saved");
  std::memcpy(data, source_.data(), size);
  source_.remove_prefix(size);
}

void StateArchive::operator()(std::uint64_t& value) { exchange(&value, sizeof value); }

void StateArchive::operator()(bool& value) {
  auto byte = static_cast<std::uint8_t>(value);
  exchange(&byte, 1);
  require(byte <= 1, "state", int{byte}, "must be 0 or 1 here");
  value = byte == 1;
}

void StateArchive::numbers(std::span<double> values) {
  exchange(values.data(), values.size_bytes());
  if (!restoring_) return;
  for (const double value : values) require(std::isfinite(value), "state", value, "must be finite");
}

void StateArchive::operator()(std::string& text) {
  std::uint64_t size = text.size();
  (*this)(size);
  require(!restoring_ || size <= source_.size(), "state", "truncated", "must be as long as it was saved");
  text.resize(size);
  exchange(text.data(), text.size());
}

void StateArchive::operator()(BodyState& state) {
  Pose& pose = state.world_from_body;
  numbers({pose.position_m.data(), 3});
  numbers({pose.orientation.coeffs().data(), 4});
  (*this)(state.velocity_body);
  const double length = pose.orientation.norm();
  require(std::abs(length - 1) < kUnitTolerance, "state.orientation", length, "must be of length 1");
}

void StateArchive::same(std::string_view what, std::uint64_t value) {
  std::uint64_t held = value;
  (*this)(held);
  require(held == value, "state." + std::string(what), held, "must be " + std::to_string(value));
}

void StateArchive::same(std::string_view what, const std::string& value) {
  std::string held = value;
  (*this)(held);
  require(held == value, "state." + std::string(what), "'" + held + "'", "must be '" + value + "'");
}

void StateArchive::finish() const {
  require(source_.empty(), "state", "too long", "must end where it was saved to end");
}

}  // namespace uwsim
