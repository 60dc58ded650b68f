#pragma once

namespace uwsim {

/// Makes Bullet throw std::bad_alloc when memory runs out. Bullet does not check its allocator's result, so the process
/// would otherwise crash with a segmentation fault. Returns true.
bool let_bullet_throw();

/// Initialized before any use of Bullet in every file that includes this header.
inline const bool kBulletThrows = let_bullet_throw();

}  // namespace uwsim
