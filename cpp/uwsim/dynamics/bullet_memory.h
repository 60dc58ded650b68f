#pragma once

namespace uwsim {

/// Makes Bullet throw std::bad_alloc when memory runs out. Bullet does not check what its allocator returns, so that
/// the process would otherwise end with a segmentation fault. Returns true.
bool let_bullet_throw();

/// Runs before any of Bullet in every file that includes this.
inline const bool kBulletThrows = let_bullet_throw();

}  // namespace uwsim
