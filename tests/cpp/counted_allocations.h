#pragma once

#include <cstdint>

namespace uwsim::testing {

/// Calls so far, by any thread and any library of this program, of malloc and its kin, and so of operator new.
/// Only for programs that link counted_allocations.cpp.
std::uint64_t allocations();

}  // namespace uwsim::testing
