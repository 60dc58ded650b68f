#pragma once

#include <pybind11/pybind11.h>

#include <utility>

/// Guards that release or acquire the interpreter's lock around work in C++. During interpreter shutdown, CPython ends
/// any thread that requests the lock with pthread_exit, which unwinds the stack; pybind11's guards, whose destructors
/// are noexcept, would then abort the process by std::terminate.
namespace uwsim::bindings {

/// Releases the GIL of this thread for its lifetime.
class GilReleased {
 public:
  GilReleased() : outer_(std::exchange(innermost_, this)), state_(PyEval_SaveThread()) {}
  ~GilReleased() noexcept(false) {
    innermost_ = outer_;
    take();
  }
  GilReleased(const GilReleased&) = delete;
  GilReleased& operator=(const GilReleased&) = delete;

 private:
  friend class GilTaken;

  /// Does nothing if the thread is already being ended, in which case it has requested the lock before.
  void take() {
    if (PyThreadState* const state = std::exchange(state_, nullptr)) PyEval_RestoreThread(state);
  }

  static inline thread_local GilReleased* innermost_ = nullptr;

  GilReleased* outer_;
  PyThreadState* state_;
};

/// Reacquires the GIL for its lifetime, within work for which a GilReleased of this thread has released it.
class GilTaken {
 public:
  GilTaken() : from_(GilReleased::innermost_) { from_->take(); }
  ~GilTaken() { from_->state_ = PyEval_SaveThread(); }
  GilTaken(const GilTaken&) = delete;
  GilTaken& operator=(const GilTaken&) = delete;

 private:
  GilReleased* from_;
};

}  // namespace uwsim::bindings
