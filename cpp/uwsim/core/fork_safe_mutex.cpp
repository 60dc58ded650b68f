#include "uwsim/core/fork_safe_mutex.h"

#include <pthread.h>

#include <chrono>
#include <stdexcept>
#include <thread>

namespace uwsim {
namespace {

std::atomic<int> generation = 0;

[[maybe_unused]] const int registered = ::pthread_atfork(nullptr, nullptr, [] { ++generation; });

}  // namespace

int fork_generation() { return generation; }

void throw_in_use_at_fork() {
  throw std::runtime_error(
      "another thread was using this object when the process was forked, so that it is unusable here: begin child "
      "processes by multiprocessing's 'spawn', or make a new object");
}

void pause_between_looks() { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }

}  // namespace uwsim
