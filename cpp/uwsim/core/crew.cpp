#include "uwsim/core/crew.h"

#include <signal.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <system_error>
#include <thread>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim {
namespace {

constexpr std::size_t kMostThreads = 1024;
constexpr int kSpins = 1000;  // some 20 us

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Blocks all signals in this thread, and in the threads that it starts, until destroyed.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

/// The crew is never destroyed, since its threads wait in it until the process ends.
Crew& Crew::shared() {
  static std::atomic<Crew*> shared{nullptr};
  Crew* crew = shared.load();
  if (crew != nullptr && crew->generation_ == fork_generation()) return *crew;
  std::unique_ptr<Crew> fresh(new Crew(fork_generation()));
  if (shared.compare_exchange_strong(crew, fresh.get())) crew = fresh.release();
  return *crew;
}

void Crew::work(std::size_t threads, const std::function<void(std::size_t)>& job) {
  if (threads <= 1) return job(0);
  Task task{job, threads};
  {
    const std::scoped_lock lock(mutex_);
    add_threads(threads - 1);
    tasks_.push_back(&task);
  }
  for (std::size_t k = 1; k < threads; ++k) has_task_.notify_one();
  job(0);
  std::unique_lock lock(mutex_);
  std::erase(tasks_, &task);
  if (task.running == 0) return;
  // The others are usually about to end, sooner than this thread could fall asleep and wake up.
  lock.unlock();
  for (int k = 0; k < kSpins && task.running != 0; ++k) pause();
  lock.lock();
  has_ended_.wait(lock, [&] { return task.running == 0; });
}

void Crew::add_threads(std::size_t wanted) {
  const SignalsBlocked blocked;
  for (; idle_ < wanted && size_ < kMostThreads; ++idle_, ++size_) {
    try {
      std::thread([this] { wait_for_tasks(); }).detach();
    } catch (const std::system_error&) {
      return;  // the system cannot start another thread
    }
  }
}

/// `idle_` counts a thread from its start, and while it waits.
void Crew::wait_for_tasks() {
  std::unique_lock lock(mutex_);
  while (true) {
    has_task_.wait(lock, [&] { return !tasks_.empty(); });
    Task& task = *tasks_.front();
    const std::size_t worker = task.begun++;
    if (task.begun == task.threads) tasks_.pop_front();
    ++task.running;
    --idle_;
    lock.unlock();
    task.job(worker);
    lock.lock();
    ++idle_;
    if (--task.running == 0) has_ended_.notify_all();
  }
}

}  // namespace uwsim
