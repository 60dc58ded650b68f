#pragma once

#include <cstdint>

namespace uwsim::testing {

/// The number of calls so far, by any thread and any library of this program, of malloc and its relatives, and so of
/// operator new. Only for programs that link counted_allocations.cpp.
std::uint64_t allocations();

}  // namespace uwsim::testing
