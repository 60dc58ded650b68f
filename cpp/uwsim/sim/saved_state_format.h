#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// The origin of a saved state: a fingerprint of the scenario, including its seed, and a fingerprint of the build.
struct StateOrigin {
  std::string scenario, build;
};

/// Returns a saved state: the bytes of `state` after a header with format, version, origin, length and checksum.
std::string wrapped_state(std::string_view state, const StateOrigin& origin);
/// Returns the bytes of the state in a saved state. Throws InvalidValue unless the saved state is complete, undamaged
/// and of this scenario. It may come from another build, whose steps may differ in the last bits.
std::string_view unwrapped_state(std::string_view bytes, const StateOrigin& origin);
/// Returns the fingerprint of the build that saved a state. Throws InvalidValue for a damaged state.
std::string saved_build(std::string_view bytes);
/// Returns the notes that were stored with a saved state. Throws like unwrapped_state.
std::string saved_notes(std::string_view bytes, const StateOrigin& origin);

}  // namespace uwsim
