#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

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

// Format a value for a message. These few functions format all values, because a stream in a header, with Eigen's
// operators, would be compiled in every file that includes it.
std::string printed_number(double value);                          ///< with six digits
std::string printed_row(const std::vector<std::string>& numbers);  ///< in columns of equal width

/// Returns the text of a number, a string or an Eigen row.
template <typename Value>
std::string printed(const Value& value) {
  if constexpr (std::is_integral_v<Value>) {
    return std::to_string(value);
  } else if constexpr (std::is_floating_point_v<Value>) {
    return printed_number(static_cast<double>(value));
  } else if constexpr (std::is_convertible_v<const Value&, std::string_view>) {
    return std::string(std::string_view(value));
  } else {
    static_assert(Value::RowsAtCompileTime == 1, "transpose a column");
    std::vector<std::string> numbers;
    for (decltype(value.size()) k = 0; k < value.size(); ++k) numbers.push_back(printed(value(k)));
    return printed_row(numbers);
  }
}

[[noreturn]] void throw_invalid(std::string_view path, const std::string& value, std::string_view rule);

/// Throws InvalidValue naming path, value and rule.
template <typename Value>
[[noreturn, gnu::cold, gnu::noinline]] void refuse_value(std::string_view path, const Value& value,
                                                         std::string_view rule) {
  throw_invalid(path, printed(value), rule);
}

/// Throws InvalidValue naming path, value and rule unless `holds`. The message is only built on failure.
template <typename Value>
void require(bool holds, std::string_view path, const Value& value, std::string_view rule) {
  if (!holds) [[unlikely]]
    refuse_value(path, value, rule);
}

}  // namespace uwsim
