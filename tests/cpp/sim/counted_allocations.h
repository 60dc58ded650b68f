#pragma once

#include <cstdint>

namespace uwsim::testing {

/// The number of calls so far to malloc and related functions, and thus to operator new, by any thread and any library
/// of this program. Only for programs that link counted_allocations.cpp.
std::uint64_t allocations();

}  // namespace uwsim::testing
