#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/estimation/exchanged_values.h"
#include "uwsim/estimation/navigation_filter.h"

namespace uwsim {
namespace {

void exchange_sample(StateArchive& archive, LastSample& sample) {
  exchange_numbers(archive, sample.force_m_s2);
  archive(sample.time_ns);
  exchange_numbers(archive, sample.rate_slope_rad_s2);
  archive(sample.slope_s);
  archive(sample.guessed_s);
}

/// The only IMU value in version 1 is the newest angular velocity; the other values are set by the next sample.
void exchange_state(StateArchive& archive, FilterState& state, std::uint64_t version) {
  archive(state.time_ns);
  exchange_numbers(archive, state.position_m);
  exchange_numbers(archive, state.velocity_m_s);
  exchange_numbers(archive, state.orientation.coeffs());
  exchange_numbers(archive, state.rate_bias_rad_s);
  exchange_numbers(archive, state.force_bias_m_s2);
  exchange_numbers(archive, state.aid_bias);
  exchange_numbers(archive, state.covariance);
  exchange_numbers(archive, state.sample.rate_rad_s);
  if (version >= 2) exchange_sample(archive, state.sample);
  for (AidCounts& counts : state.counts) {
    archive(counts.accepted);
    archive(counts.rejected);
    archive(counts.in_a_row);
    if (version < 3) counts.noise_variance = 0;
    if (version >= 3) exchange_not_negative(archive, counts.noise_variance);
    if (version < 6) counts.level_variance = 0;
    if (version >= 6) exchange_not_negative(archive, counts.level_variance);
  }
  archive(state.doubts);
  archive(state.doubted_ns);
  archive(state.restarted_ns);
}

/// Inserts error `k`, with an estimated bias of 0 and this variance, uncorrelated with the other errors.
void put_in(FilterState& state, int k, double variance) {
  const int after = state.errors() - k;
  const ErrorVector bias = state.aid_bias;
  const ErrorMatrix p = state.covariance;
  state.aid_bias.resize(bias.size() + 1);
  state.aid_bias << bias.head(k - kAidBias), 0, bias.tail(after);
  state.covariance.setZero(p.rows() + 1, p.rows() + 1);
  state.covariance.topLeftCorner(k, k) = p.topLeftCorner(k, k);
  state.covariance.topRightCorner(k, after) = p.topRightCorner(k, after);
  state.covariance.bottomLeftCorner(after, k) = p.bottomLeftCorner(after, k);
  state.covariance.bottomRightCorner(after, after) = p.bottomRightCorner(after, after);
  state.covariance(k, k) = variance;
}

}  // namespace

void NavigationFilter::exchange(StateArchive& archive, std::uint64_t version) {
  for (const auto& aid : aids_) aid->be_as_in(version);
  collect_biases();
  FilterState& state = checkpoints_.front().state;
  std::vector<int> lacking;  // the errors that this version lacks, in order
  for (const auto& aid : aids_) {
    const int biases = static_cast<int>(aid->biases().size());
    for (int k = aid->biases_in(version); k < biases; ++k) {
      lacking.push_back(aid->first_bias + k);
    }
  }
  if (!lacking.empty()) {
    const auto errors = state.errors() - static_cast<Eigen::Index>(lacking.size());
    state.aid_bias.resize(errors - kAidBias);
    state.covariance.resize(errors, errors);
  }
  archive.same("filter's errors", static_cast<std::uint64_t>(state.errors()));
  const auto known = std::ranges::count_if(aids_, [&](const auto& aid) { return aid->since_version() <= version; });
  archive.same("filter's aids", static_cast<std::uint64_t>(known));
  archive(too_late_);
  if (version >= 2) exchange_parameters(archive, version);
  exchange_state(archive, state, version);
  for (const int k : lacking) put_in(state, k, aid_biases_[static_cast<std::size_t>(k - kAidBias)].variance());
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
void NavigationFilter::exchange_parameters(StateArchive& archive, std::uint64_t version) {
  inertial_.exchange_parameters(archive);
  for (const auto& aid : aids_) {
    if (aid->since_version() <= version) aid->exchange_parameters(archive, version);
  }
  collect_biases();
}

void NavigationFilter::collect_biases() {
  aid_biases_.clear();
  for (const auto& aid : aids_) {
    const std::vector<BiasModel> biases = aid->biases();
    aid_biases_.insert(aid_biases_.end(), biases.begin(), biases.end());
  }
}

std::string NavigationFilter::save() {
  require(!checkpoints_.empty(), "filter", "not started", "start() comes first");
  catch_up();
  forget_all_but(last_before_horizon());
  StateArchive archive;
  exchange(archive, kVersion);
  return archive.bytes();
}

void NavigationFilter::restore(std::string_view bytes, std::uint64_t version) {
  require(version >= 1 && version <= kVersion, "state.version", version,
          "must be 1 to 6: another version of uwsim saved it, in a format that this one lacks");
  start({});
  StateArchive archive(bytes);
  exchange(archive, version);
  archive.finish();
  present_ = checkpoints_.front().state;
  next_ = changed_ = 0;
  catch_up();
}

}  // namespace uwsim
