#pragma once

#include <pybind11/pybind11.h>

#include <map>
#include <string>
#include <vector>

#include "uwsim/core/parameter.h"

namespace uwsim::bindings {

/// Returns {name: Parameter}, sorted by name.
template <typename Parameters>
std::map<std::string, Parameter> by_name(const Parameters& parameters) {
  std::map<std::string, Parameter> named;
  for (const Parameter& parameter : parameters) named.emplace(parameter.name, parameter);
  return named;
}

/// The names of registered kinds, in order of registration.
template <typename Kinds>
std::vector<std::string> kind_names(const Kinds& kinds) {
  std::vector<std::string> names;
  for (const auto* kind : kinds) names.emplace_back(kind->name);
  return names;
}

}  // namespace uwsim::bindings
