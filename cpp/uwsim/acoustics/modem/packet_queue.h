#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "uwsim/core/state_archive.h"

namespace uwsim {

/// A message from one node to another. Times are in nanoseconds of simulated time.
struct LinkMessage {
  std::uint64_t number = 0;    ///< sequence number among all messages of the network
  std::uint64_t to = 0;        ///< receiving node
  std::uint64_t topic = 0;     ///< index of the topic, for counting
  std::uint64_t priority = 0;  ///< 0 is sent first
  std::uint64_t given_ns = 0;
  std::uint64_t deadline_ns = 0;  ///< the message is dropped if sending has not begun by then; 0: no deadline
  bool replaces = false;          ///< replaces an older message of its topic and receiver whose sending has not begun
  bool signal = false;            ///< sent by an instrument; does not reset the failsafe's silence timer
  std::uint64_t repeats = 0;      ///< number of further times that the whole message is sent
  std::string payload;
  std::uint64_t packets_sent = 0;
  bool again = false;  ///< whether it has been sent before

  void exchange_state(StateArchive& archive);
};

inline constexpr std::uint64_t kRepeatsMax = 1000;

/// The messages waiting at a node, ordered by priority number (lowest first) and then by age (oldest first). Every
/// operation takes at most logarithmic time.
class PacketQueue {
 public:
  enum class Added { kQueued, kReplaced, kRefused };
  /// Adds a message, unless the queue would then exceed `bytes_max`. If the message replaces another one, that one is
  /// moved to `replaced`.
  Added add(LinkMessage message, std::uint64_t bytes_max, LinkMessage& replaced);
  bool empty() const { return messages_.empty(); }
  std::size_t size() const { return messages_.size(); }
  std::uint64_t bytes() const { return bytes_; }
  /// Removes the messages whose deadlines have passed and calls `tell` for each, in order of their deadlines.
  template <typename Tell>
  void expire(std::uint64_t now_ns, const Tell& tell) {
    while (!deadlines_.empty() && deadlines_.begin()->first <= now_ns) {
      const auto found = messages_.find(deadlines_.begin()->second);
      deadlines_.erase(deadlines_.begin());
      if (found == messages_.end() || found->second.packets_sent > 0) continue;
      tell(found->second);
      take(found);
    }
  }
  /// The message whose packets are sent next; the queue must not be empty.
  LinkMessage& front() { return messages_.begin()->second; }
  LinkMessage take_front() { return take(messages_.begin()); }
  /// Returns a copy of front(), and moves that message behind all others of the same priority.
  LinkMessage repeat_front();
  bool holds(std::uint64_t number) const { return numbers_.contains(number); }
  /// All messages, in order of submission.
  std::vector<const LinkMessage*> messages() const;

  void exchange_state(StateArchive& archive);

 private:
  struct Place {
    std::uint64_t priority;
    std::uint64_t order;  // of submission
    auto operator<=>(const Place&) const = default;
  };
  using Messages = std::map<Place, LinkMessage>;

  void insert(LinkMessage message);
  LinkMessage take(Messages::iterator from);
  /// The oldest message that this new message replaces.
  Messages::iterator replaced_by(const LinkMessage& message);

  Messages messages_;
  std::set<std::pair<std::uint64_t, Place>> deadlines_;  // of waiting messages, and of some that are already being sent
  std::set<Place> replaceable_;                          // a few per topic
  std::unordered_set<std::uint64_t> numbers_;
  std::uint64_t bytes_ = 0;
  std::uint64_t next_order_ = 0;
};

}  // namespace uwsim
