#pragma once

#include <string>
#include <string_view>

#include "uwsim/core/check.h"

namespace uwsim {

/// A value with its unit, such as `3 m`; for use with `require`. Holds a reference to the value.
template <typename Value>
struct WithUnit {
  const Value& value;
  std::string_view unit;
};

template <typename Value>
WithUnit<Value> with_unit(const Value& value, std::string_view unit) {
  return {value, unit};
}

template <typename Value>
std::string printed(const WithUnit<Value>& value) {
  return printed(value.value).append(" ").append(value.unit);
}

}  // namespace uwsim
