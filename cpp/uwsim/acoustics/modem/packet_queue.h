#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/core/state_archive.h"

namespace uwsim {

/// A message from one node to another. Times in nanoseconds of simulated time.
struct LinkMessage {
  std::uint64_t number = 0;    ///< counts all messages of the network
  std::uint64_t to = 0;        ///< receiving node
  std::uint64_t topic = 0;     ///< index of the topic, for counting
  std::uint64_t priority = 0;  ///< 0 is sent first
  std::uint64_t given_ns = 0;
  std::uint64_t deadline_ns = 0;  ///< dropped if sending has not begun by then; 0: never
  bool replaces = false;          ///< replaces an older message of its topic and receiver whose sending has not begun
  bool signal = false;            ///< sent by an instrument: does not reset the failsafe's silence timer
  std::uint64_t repeats = 0;      ///< how many more times it is sent as a whole
  std::string payload;
  std::uint64_t packets_sent = 0;
  bool again = false;  ///< whether it has been sent before

  void exchange_state(StateArchive& archive);
};

inline constexpr std::uint64_t kRepeatsMax = 1000;

/// The messages waiting at a node: the lowest priority number first, then the oldest.
class PacketQueue {
 public:
  enum class Added { kQueued, kReplaced, kRefused };
  /// Refuses a message that would exceed `bytes_max`. replaced: receives the message that it replaces, if any.
  Added add(LinkMessage message, std::uint64_t bytes_max, LinkMessage& replaced);
  bool empty() const { return messages_.empty(); }
  std::size_t size() const { return messages_.size(); }
  std::uint64_t bytes() const { return bytes_; }
  /// Removes messages whose deadline has passed and calls `tell` for each.
  template <typename Tell>
  void expire(std::uint64_t now_ns, const Tell& tell) {
    if (now_ns < next_deadline_ns_) return;
    for (std::size_t k = messages_.size(); k-- > 0;) {
      if (!has_expired(messages_[k], now_ns)) continue;
      tell(messages_[k]);
      remove(k);
    }
    find_next_deadline();
  }
  /// The message to send from next; the queue must not be empty.
  LinkMessage& front() { return messages_[first()]; }
  LinkMessage take_front();
  /// Returns a copy of the message to send from next, which is queued again behind its equals.
  LinkMessage repeat_front();
  bool holds(std::uint64_t number) const;
  const std::vector<LinkMessage>& messages() const { return messages_; }

  void exchange_state(StateArchive& archive);

 private:
  static bool has_expired(const LinkMessage& message, std::uint64_t now_ns) {
    return message.deadline_ns > 0 && message.packets_sent == 0 && now_ns >= message.deadline_ns;
  }
  std::size_t first() const;
  void remove(std::size_t index);
  void find_next_deadline();

  std::vector<LinkMessage> messages_;  // in order of submission
  std::uint64_t bytes_ = 0;
  std::uint64_t next_deadline_ns_ = ~std::uint64_t{0};
};

}  // namespace uwsim
