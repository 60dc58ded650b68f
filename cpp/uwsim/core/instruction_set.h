#pragma once

#include <cstdint>

namespace uwsim {

/// The instruction sets that kernels are compiled for: *_avx2.cpp, *_avx512.cpp and a portable one. `best` is a request
/// for the widest that the processor has.
enum class InstructionSet : std::uint8_t { best, portable, avx2, avx512 };

/// Whether this processor has every instruction that the compiler may use in the kernels of `set`.
/// cpp/uwsim/CMakeLists.txt lists the flags; tests/python/whole/test_architecture.py compares the two.
bool processor_has(InstructionSet set);
/// The instruction set in the environment variable UWSIM_INSTRUCTION_SET (portable, avx2 or avx512), so that CPUs of
/// different kinds produce the same bytes; best if it is unset. Throws InvalidValue for any other word, or for a set
/// that this processor lacks.
InstructionSet chosen_instruction_set();
/// The chosen set, else the widest that this processor has: portable, avx2 or avx512. Throws as
/// chosen_instruction_set().
InstructionSet widest_instruction_set();
const char* instruction_set_name(InstructionSet set);

/// The table of kernels for the chosen set, else for the widest.
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
