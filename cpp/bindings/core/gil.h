#pragma once

#include <pybind11/pybind11.h>

#include <utility>

/// Guards that release or acquire the interpreter's lock (GIL) around work in C++. During interpreter shutdown, CPython
/// calls pthread_exit in any thread that requests the lock. This unwinds the stack, and pybind11's guards, whose
/// destructors are noexcept, would then abort the process through std::terminate.
namespace uwsim::bindings {

/// Releases the GIL, which this thread holds, for the lifetime of the guard.
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

  /// Acquires the GIL. Does nothing if the lock has already been requested, because the thread is then being ended.
  void take() {
    if (PyThreadState* const state = std::exchange(state_, nullptr)) PyEval_RestoreThread(state);
  }

  static inline thread_local GilReleased* innermost_ = nullptr;

  GilReleased* outer_;
  PyThreadState* state_;
};

/// Reacquires the GIL for the lifetime of the guard, in a scope where a GilReleased of this thread has released it.
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
