#include "uwsim/dynamics/bullet_memory.h"

#include <LinearMath/btAlignedAllocator.h>
#include <gtest/gtest.h>

#include <new>

#include "sanitized.h"

namespace uwsim {
namespace {

TEST(BulletMemory, BulletThrowsWhereThereIsNone) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's malloc ends the process";
  EXPECT_THROW(btAlignedAlloc(std::size_t{1} << 60, 16), std::bad_alloc);
}

}  // namespace
}  // namespace uwsim
