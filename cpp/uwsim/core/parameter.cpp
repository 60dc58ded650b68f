#include "uwsim/core/parameter.h"

#include <cmath>
#include <sstream>

namespace uwsim {
namespace {

void require_in_range(const Parameter& parameter, double value, const std::string& path) {
  const bool whole = parameter.type == ParameterType::kNumber || value == std::floor(value);
  if (whole && value >= parameter.low && value <= parameter.high) return;
  const std::string unit = parameter.unit.empty() ? "" : ' ' + std::string(parameter.unit);
  std::ostringstream message;
  message << path << " = " << value << unit << ": must be " << (whole ? "" : "a whole number ") << "in ";
  if (parameter.low == kAboveZero) {
    message << "(0";
  } else {
    message << '[' << parameter.low;
  }
  message << ", " << parameter.high << ']' << unit;
  throw InvalidValue(message.str());
}

}  // namespace

void complete_parameters(ParameterValues& values, std::span<const Parameter> parameters, const std::string& path) {
  for (const auto& [name, given] : values) require_known(name, parameters, path + ".parameters");
  for (const Parameter& parameter : parameters) {
    const std::string name(parameter.name), at = path + "." + name;
    const auto width = static_cast<std::size_t>(parameter.width);
    if (!std::isnan(parameter.by_default)) values.try_emplace(name, width, parameter.by_default);
    require(values.contains(name), at, "missing", "must be given");
    const std::vector<double>& given = values.at(name);
    require(given.size() == width, at, std::to_string(given.size()) + " values",
            "must have " + std::to_string(parameter.width));
    for (const double value : given) require_in_range(parameter, value, at);
  }
}

double number(const ParameterValues& values, std::string_view name) { return values.find(name)->second.front(); }

int whole_number(const ParameterValues& values, std::string_view name) {
  return static_cast<int>(number(values, name));
}

bool flag(const ParameterValues& values, std::string_view name) { return number(values, name) != 0; }

InvalidValue unknown_name(std::string_view name, std::span<const std::string_view> known, const std::string& path) {
  std::string names;
  for (const std::string_view other : known) names += (names.empty() ? "" : ", ") + std::string(other);
  return InvalidValue(path + " = " + std::string(name) + ": must be one of " + (names.empty() ? "none" : names));
}

}  // namespace uwsim
