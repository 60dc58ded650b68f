#pragma once

#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/check.h"

namespace uwsim {

inline constexpr double kRequired = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kAboveZero = std::numeric_limits<double>::denorm_min();

enum class ParameterType { kNumber, kWholeNumber, kFlag };

/// A parameter of a kind of sensor or sonar, as listed in the table in that kind's source file.
struct Parameter {
  std::string_view name;
  int width;          ///< number of values
  double by_default;  ///< default of each value; kRequired if there is none
  double low, high;   ///< limits of each value; kAboveZero as the lower limit excludes 0
  std::string_view unit;
  std::string_view meaning;
  ParameterType type = ParameterType::kNumber;
};

using ParameterValues = std::map<std::string, std::vector<double>, std::less<>>;

/// Fills in the defaults. Throws InvalidValue naming `path`.<name> for an unknown or missing parameter, a wrong number
/// of values, or a value out of range.
void complete_parameters(ParameterValues& values, std::span<const Parameter> parameters, const std::string& path);

/// Returns the value of a parameter from values that complete_parameters() has completed.
double number(const ParameterValues& values, std::string_view name);
int whole_number(const ParameterValues& values, std::string_view name);
bool flag(const ParameterValues& values, std::string_view name);

/// Returns the error "`path` = `name`: must be one of ...".
InvalidValue unknown_name(std::string_view name, std::span<const std::string_view> known, const std::string& path);

/// Throws unknown_name unless one of the items has that name.
template <typename Items>
void require_known(std::string_view name, const Items& items, const std::string& path) {
  std::vector<std::string_view> known;
  for (const auto& item : items) {
    if (item.name == name) return;
    known.push_back(item.name);
  }
  throw unknown_name(name, known, path);
}

/// Returns the kind with that name from a table of pointers to kinds. Throws unknown_name.
template <typename Kinds>
const auto& find_kind(const Kinds& kinds, std::string_view name, const std::string& path) {
  std::vector<std::string_view> known;
  for (const auto* kind : kinds) {
    if (kind->name == name) return *kind;
    known.push_back(kind->name);
  }
  throw unknown_name(name, known, path);
}

}  // namespace uwsim
