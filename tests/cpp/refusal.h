#pragma once

#include <string>

#include "uwsim/core/check.h"

namespace uwsim {

/// Returns the message with which `act` is refused; empty if it is not.
template <typename Act>
std::string refusal(const Act& act) {
  try {
    act();
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "";
}

}  // namespace uwsim
