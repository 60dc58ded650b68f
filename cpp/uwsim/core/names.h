#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/parameter.h"

namespace uwsim {

/// Returns the index of `name` in `names`. If it is not there, throws InvalidValue naming `path` and listing the names.
template <typename Names>
std::size_t index_of(std::string_view path, std::string_view name, const Names& names) {
  const auto found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names)) {
    throw unknown_name(name, std::vector<std::string_view>(std::begin(names), std::end(names)), std::string(path));
  }
  return static_cast<std::size_t>(std::distance(std::begin(names), found));
}

}  // namespace uwsim
