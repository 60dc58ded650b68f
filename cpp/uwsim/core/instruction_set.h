#pragma once

#include <cstdint>

/// 1 if kernels for AVX2 and AVX-512 are compiled. For other processors, CMake omits files with such instructions, and
/// compiles the other kernels without these flags.
#if defined(__x86_64__)
#define UWSIM_X86 1
#else
#define UWSIM_X86 0
#endif

namespace uwsim {

/// The instruction sets that kernels are compiled for: *_avx2.cpp, *_avx512.cpp and a portable version. `best` requests
/// the widest that the processor supports.
enum class InstructionSet : std::uint8_t { best, portable, avx2, avx512 };

/// Whether this processor supports every instruction that the compiler may use in the kernels of `set`.
/// cpp/uwsim/CMakeLists.txt lists the flags; tests/python/whole/test_architecture.py compares the two.
bool processor_has(InstructionSet set);
/// The instruction set named by the environment variable UWSIM_INSTRUCTION_SET (portable, avx2 or avx512), or `best` if
/// the variable is unset. Choosing a set makes different kinds of CPU produce the same bytes. Throws InvalidValue for
/// any other value, or for a set that this processor does not support.
InstructionSet chosen_instruction_set();
/// The chosen set if the variable is set, else the widest set that this processor supports: portable, avx2 or avx512.
/// Throws like chosen_instruction_set().
InstructionSet widest_instruction_set();
const char* instruction_set_name(InstructionSet set);

/// Selects the table of kernels for widest_instruction_set(); uwsim_kernels() in cpp/uwsim/CMakeLists.txt generates the
/// calls, and the functions that return the tables.
template <typename Kernels>
const Kernels& widest(const Kernels& portable, const Kernels& avx2, const Kernels& avx512) {
  switch (widest_instruction_set()) {
    case InstructionSet::avx512:
      return avx512;
    case InstructionSet::avx2:
      return avx2;
    default:
      return portable;
  }
}

}  // namespace uwsim
