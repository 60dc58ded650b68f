#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/core/state_archive.h"

namespace uwsim {

/// A message that one node has for another. Times in nanoseconds of simulated time.
struct LinkMessage {
  std::uint64_t number = 0;    ///< counts all messages of the network
  std::uint64_t to = 0;        ///< a node
  std::uint64_t topic = 0;     ///< index of the topic, for counts
  std::uint64_t priority = 0;  ///< 0 goes first
  std::uint64_t given_ns = 0;
  std::uint64_t deadline_ns = 0;  ///< it is dropped if it has not begun to be sent by then; 0: never
  bool replaces = false;  ///< takes the place of an older one of its topic and receiver that has not begun to be sent
  bool signal = false;    ///< of an instrument: it ends nobody's silence
  std::uint64_t repeats = 0;  ///< how often it is still to be sent again, whole
  std::string payload;
  std::uint64_t packets_sent = 0;
  bool again = false;  ///< it has been sent before

  void exchange_state(StateArchive& archive);
};

inline constexpr std::uint64_t kRepeatsMax = 1000;

/// The messages that wait at a node: the lowest priority number first, then the oldest.
class PacketQueue {
 public:
  enum class Added { kQueued, kReplaced, kRefused };
  /// Refuses a message for which `bytes_max` leave no room. replaced: gets the one that it takes the place of.
  Added add(LinkMessage message, std::uint64_t bytes_max, LinkMessage& replaced);
  bool empty() const { return messages_.empty(); }
  std::size_t size() const { return messages_.size(); }
  std::uint64_t bytes() const { return bytes_; }
  /// Removes the messages whose deadline has passed, telling of each.
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
  /// The message to send from next; not empty.
  LinkMessage& front() { return messages_[first()]; }
  LinkMessage take_front();
  /// Returns a copy of the message to send from next, which waits behind its like to be sent again.
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

  std::vector<LinkMessage> messages_;  // in the order in which they were given
  std::uint64_t bytes_ = 0;
  std::uint64_t next_deadline_ns_ = ~std::uint64_t{0};
};

}  // namespace uwsim
