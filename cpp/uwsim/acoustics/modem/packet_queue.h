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
  std::uint64_t from = 0;      ///< node that submitted it
  std::uint64_t to = 0;        ///< its destination
  std::uint64_t topic = 0;     ///< index of the topic, for counting
  std::uint64_t priority = 0;  ///< 0 is sent first
  std::uint64_t given_ns = 0;
  std::uint64_t deadline_ns = 0;  ///< the message is dropped if sending has not begun by then; 0: no deadline
  bool replaces = false;          ///< replaces an older message of its topic and receiver whose sending has not begun
  bool signal = false;            ///< sent by an instrument; does not reset the failsafe's silence timer
  std::uint64_t repeats = 0;      ///< number of times that the whole message is still sent again in any case
  std::uint64_t retransmissions = 0;   ///< number of times that it is still sent again while not acknowledged
  std::uint64_t held_until_ns = 0;     ///< time until which it waits for its acknowledgement
  std::uint64_t acknowledges = kNone;  ///< number of the message that this one acknowledges
  std::string payload;
  std::uint64_t packets_sent = 0;
  bool again = false;  ///< whether it has been sent before

  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  void exchange_state(StateArchive& archive);
};

inline constexpr std::uint64_t kRepeatsMax = 1000;

/// The messages waiting at a node, ordered by priority number (lowest first) and then by age (oldest first). Messages
/// that wait for their acknowledgements are passed over. Apart from these, operations take at most logarithmic time.
class PacketQueue {
 public:
  enum class Added { kQueued, kReplaced, kRefused };
  /// Adds a message, unless the queue would then exceed `bytes_max`. If the message replaces an older one, the older
  /// one is moved to `replaced`.
  Added add(LinkMessage message, std::uint64_t bytes_max, LinkMessage& replaced);
  bool empty() const { return messages_.empty(); }
  std::size_t size() const { return messages_.size(); }
  std::uint64_t bytes() const { return bytes_; }
  /// Removes the messages whose deadlines have passed and calls `report` for each, in order of their deadlines.
  template <typename Report>
  void expire(std::uint64_t now_ns, const Report& report) {
    while (!deadlines_.empty() && deadlines_.begin()->first <= now_ns) {
      const auto found = messages_.find(deadlines_.begin()->second);
      deadlines_.erase(deadlines_.begin());
      if (found == messages_.end() || found->second.packets_sent > 0) continue;
      report(found->second);
      remove(found);
    }
  }
  /// The message whose packets are sent next, or nullptr if there is none or all are held.
  LinkMessage* next(std::uint64_t now_ns);
  /// Removes and returns next(), which must exist.
  LinkMessage pop_next(std::uint64_t now_ns) { return remove(find_next(now_ns)); }
  /// Returns a copy of next(), which must exist, and moves the message behind all others of the same priority, to be
  /// sent again: a retransmission is held until `held_until_ns`, a repeat is not held.
  LinkMessage repeat_next(std::uint64_t now_ns, std::uint64_t held_until_ns);
  /// Drops the remaining transmissions of a message; one that has begun is completed. Returns whether the message has
  /// been removed.
  bool finish(std::uint64_t number);
  bool holds(std::uint64_t number) const { return numbers_.contains(number); }
  /// All messages, in order of submission.
  std::vector<const LinkMessage*> messages() const;

  /// Saves or restores the queue.
  void exchange_state(StateArchive& archive);

 private:
  struct Place {
    std::uint64_t priority;
    std::uint64_t order;  // of submission
    auto operator<=>(const Place&) const = default;
  };
  using Messages = std::map<Place, LinkMessage>;

  Messages::iterator find_next(std::uint64_t now_ns);
  void insert(LinkMessage message);
  LinkMessage remove(Messages::iterator from);
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
