#include <bit>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/estimation/navigation_filter.h"

namespace uwsim {
namespace {

template <typename Values>
void exchange_numbers(StateArchive& archive, Values&& values) {
  for (Eigen::Index k = 0; k < values.size(); ++k) archive(values.data()[k]);
}

void exchange_state(StateArchive& archive, FilterState& state) {
  archive(state.time_ns);
  exchange_numbers(archive, state.position_m);
  exchange_numbers(archive, state.velocity_m_s);
  exchange_numbers(archive, state.orientation.coeffs());
  exchange_numbers(archive, state.rate_bias_rad_s);
  exchange_numbers(archive, state.force_bias_m_s2);
  exchange_numbers(archive, state.aid_bias);
  exchange_numbers(archive, state.covariance);
  exchange_numbers(archive, state.measured_rate_rad_s);
  for (AidCounts& counts : state.counts) {
    archive(counts.accepted);
    archive(counts.rejected);
    archive(counts.in_a_row);
  }
  archive(state.doubts);
  archive(state.doubted_ns);
  archive(state.restarted_ns);
}

}  // namespace

void NavigationFilter::exchange(StateArchive& archive) {
  archive.same("filter's errors", static_cast<std::uint64_t>(kAidBias + aid_biases_.size()));
  archive.same("filter's aids", aids_.size());
  archive(too_late_);
  exchange_state(archive, checkpoints_.front().state);
  std::uint64_t count = events_.size();
  archive(count);
  if (archive.restoring()) events_.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    Event event = archive.restoring() ? Event{} : events_[k];
    archive(event.time_ns);
    auto source = static_cast<std::uint64_t>(event.source - kSilence);
    archive(source);
    require(source < aids_.size() + 2, "state.source", source, "must be that of an aid");
    event.source = static_cast<int>(source) + kSilence;
    for (double& value : event.values) {
      auto bits = std::bit_cast<std::uint64_t>(value);  // NaN for a lost beam
      archive(bits);
      value = std::bit_cast<double>(bits);
    }
    if (archive.restoring()) events_.push_back(event);
  }
}

std::string NavigationFilter::save() {
  require(!checkpoints_.empty(), "filter", "not started", "start() comes first");
  catch_up();
  forget_all_but(last_before_horizon());
  StateArchive archive;
  exchange(archive);
  return archive.bytes();
}

void NavigationFilter::restore(std::string_view bytes) {
  start({});
  StateArchive archive(bytes);
  exchange(archive);
  archive.finish();
  present_ = checkpoints_.front().state;
  next_ = changed_ = 0;
  catch_up();
}

}  // namespace uwsim
