#include "uwsim/acoustics/modem/packet_queue.h"

#include <algorithm>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

void LinkMessage::exchange_state(StateArchive& archive) {
  archive(number);
  archive(to);
  archive(topic);
  archive(priority);
  archive(given_ns);
  archive(deadline_ns);
  archive(replaces);
  archive(signal);
  archive(repeats);
  archive(payload);
  archive(packets_sent);
  archive(again);
}

PacketQueue::Added PacketQueue::add(LinkMessage message, std::uint64_t bytes_max, LinkMessage& replaced) {
  const auto older = std::find_if(messages_.begin(), messages_.end(), [&](const LinkMessage& other) {
    return message.replaces && other.replaces && other.packets_sent == 0 && other.topic == message.topic &&
           other.to == message.to;
  });
  const std::uint64_t freed = older == messages_.end() ? 0 : older->payload.size();
  if (bytes_ - freed + message.payload.size() > bytes_max) return Added::kRefused;
  const Added added = older == messages_.end() ? Added::kQueued : Added::kReplaced;
  if (added == Added::kReplaced) {
    replaced = *older;
    remove(static_cast<std::size_t>(older - messages_.begin()));
  }
  bytes_ += message.payload.size();
  messages_.push_back(std::move(message));
  find_next_deadline();
  return added;
}

std::size_t PacketQueue::first() const {
  const auto found = std::min_element(messages_.begin(), messages_.end(), [](const auto& a, const auto& b) {
    return a.priority < b.priority;  // among equals, the first
  });
  return static_cast<std::size_t>(found - messages_.begin());
}

LinkMessage PacketQueue::take_front() {
  const std::size_t index = first();
  LinkMessage taken = messages_[index];
  remove(index);
  return taken;
}

LinkMessage PacketQueue::repeat_front() {
  const auto front = messages_.begin() + static_cast<std::ptrdiff_t>(first());
  LinkMessage copy = *front;
  front->packets_sent = 0;
  front->again = true;
  --front->repeats;
  std::rotate(front, front + 1, messages_.end());
  find_next_deadline();
  return copy;
}

bool PacketQueue::holds(std::uint64_t number) const {
  return std::any_of(messages_.begin(), messages_.end(), [&](const auto& held) { return held.number == number; });
}

void PacketQueue::remove(std::size_t index) {
  bytes_ -= messages_[index].payload.size();
  messages_.erase(messages_.begin() + static_cast<std::ptrdiff_t>(index));
}

void PacketQueue::find_next_deadline() {
  next_deadline_ns_ = ~std::uint64_t{0};
  for (const LinkMessage& message : messages_) {
    if (message.deadline_ns > 0 && message.packets_sent == 0) {
      next_deadline_ns_ = std::min(next_deadline_ns_, message.deadline_ns);
    }
  }
}

void PacketQueue::exchange_state(StateArchive& archive) {
  archive.list(messages_, [&](LinkMessage& message) { message.exchange_state(archive); });
  bytes_ = 0;
  for (const LinkMessage& message : messages_) bytes_ += message.payload.size();
  find_next_deadline();
}

}  // namespace uwsim
