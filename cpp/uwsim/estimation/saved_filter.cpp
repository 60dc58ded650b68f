#include "uwsim/core/check.h"
#include "uwsim/estimation/exchanged_values.h"
#include "uwsim/estimation/navigation_filter.h"

namespace uwsim {
namespace {

void exchange_sample(StateArchive& archive, LastSample& sample) {
  exchange_numbers(archive, sample.rate_rad_s, sample.force_m_s2, sample.rate_slope_rad_s2);
  archive(sample.time_ns);
  archive(sample.slope_s);
  archive(sample.guessed_s);
}

void exchange_state(StateArchive& archive, FilterState& state) {
  archive(state.time_ns);
  exchange_numbers(archive, state.position_m, state.velocity_m_s, state.orientation.coeffs(), state.rate_bias_rad_s,
                   state.force_bias_m_s2, state.aid_bias, state.covariance);
  exchange_sample(archive, state.sample);
  for (AidCounts& counts : state.counts) {
    archive(counts.accepted);
    archive(counts.rejected);
    archive(counts.in_a_row);
    exchange_not_negative(archive, counts.noise_variance, counts.level_variance);
  }
  archive(state.doubts);
  archive(state.doubted_ns);
  archive(state.restarted_ns);
}

}  // namespace

void NavigationFilter::exchange(StateArchive& archive) {
  FilterState& state = checkpoints_.front().state;
  archive.same("filter's errors", static_cast<std::uint64_t>(state.errors()));
  archive.same("filter's aids", aids_.size());
  archive(too_late_);
  exchange_parameters(archive);
  exchange_state(archive, state);
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
    for (double& value : event.values) exchange_any(archive, value);  // NaN for a lost beam
    if (archive.restoring()) events_.push_back(event);
  }
}

/// A restored filter uses the parameters in the saved state, regardless of those it was constructed with.
void NavigationFilter::exchange_parameters(StateArchive& archive) {
  inertial_.exchange_parameters(archive);
  std::vector<BiasModel> biases = inertial_.matrix_biases();
  for (const auto& aid : aids_) {
    aid->exchange_parameters(archive);
    require(kAidBias + biases.size() == static_cast<std::size_t>(aid->first_bias), "state.biases", biases.size(),
            "must be as many as the filter's");
    const std::vector<BiasModel> more = aid->biases();
    biases.insert(biases.end(), more.begin(), more.end());
  }
  require(biases.size() == aid_biases_.size(), "state.biases", biases.size(), "must be as many as the filter's");
  aid_biases_ = std::move(biases);
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
