#pragma once

#include <ostream>
#include <string_view>

namespace uwsim {

/// Prints a value with its unit, such as `3 m`; for use with `require`. Holds a reference to the value.
template <typename Value>
struct WithUnit {
  const Value& value;
  std::string_view unit;

  friend std::ostream& operator<<(std::ostream& out, const WithUnit& shown) {
    return out << shown.value << ' ' << shown.unit;
  }
};

template <typename Value>
WithUnit<Value> with_unit(const Value& value, std::string_view unit) {
  return {value, unit};
}

}  // namespace uwsim
