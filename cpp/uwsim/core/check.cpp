#include "uwsim/core/check.h"

#include <algorithm>
#include <sstream>

namespace uwsim {

std::string printed_number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string printed_row(const std::vector<std::string>& numbers) {
  std::size_t width = 0;
  for (const std::string& number : numbers) width = std::max(width, number.size());
  std::string row;
  for (const std::string& number : numbers) {
    if (!row.empty()) row += ' ';
    row.append(width - number.size(), ' ') += number;
  }
  return row;
}

void throw_invalid(std::string_view path, const std::string& value, std::string_view rule) {
  throw InvalidValue(std::string(path).append(" = ").append(value).append(": ").append(rule));
}

}  // namespace uwsim
