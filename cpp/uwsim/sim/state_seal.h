#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// What a saved state belongs to: fingerprints of the scenario, seed included, and of the program.
struct StateOrigin {
  std::string scenario, build;
};

/// The figures with a header before them: what they are, their version, origin, length and checksum.
std::string sealed_state(std::string_view figures, const StateOrigin& origin);
/// The figures of a sealed state. Throws InvalidValue unless it is whole, undamaged and of this origin.
std::string_view unsealed_state(std::string_view bytes, const StateOrigin& origin);

}  // namespace uwsim
