#include "uwsim/dynamics/bullet_memory.h"

#include <LinearMath/btAlignedAllocator.h>

#include <cstdlib>
#include <new>

namespace uwsim {
namespace {

void* allocated(std::size_t size) {
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

bool let_bullet_throw() {
  btAlignedAllocSetCustom(allocated, std::free);
  return true;
}

}  // namespace uwsim
