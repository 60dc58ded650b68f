#pragma once

#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace uwsim {

/// Thrown for a value that breaks a rule; ValueError in Python. what() reads "<path> = <value> <unit>: <rule>", such as
/// "sonar.range_max_m = 900 m: must be in [0.1, 500] m".
class InvalidValue : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Thrown for a file that cannot be read or written; OSError in Python.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws InvalidValue naming path, value and rule unless `holds`. The message is only built on failure.
template <typename Value>
void require(bool holds, std::string_view path, const Value& value, std::string_view rule) {
  if (holds) return;
  std::ostringstream message;
  message << path << " = " << value << ": " << rule;
  throw InvalidValue(message.str());
}

}  // namespace uwsim
