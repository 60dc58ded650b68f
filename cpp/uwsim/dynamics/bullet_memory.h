#pragma once

namespace uwsim {

/// Makes Bullet throw std::bad_alloc where there is no memory. It writes into what its allocator returns without a
/// look, so that the process would end by a segmentation fault. Returns true.
bool let_bullet_throw();

/// Before any of Bullet runs, for whoever includes this.
inline const bool kBulletThrows = let_bullet_throw();

}  // namespace uwsim
