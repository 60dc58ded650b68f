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
  for (std::uint64_t* value : {&from, &retransmissions, &held_until_ns, &acknowledges}) archive(*value);
}

PacketQueue::Added PacketQueue::add(LinkMessage message, std::uint64_t bytes_max, LinkMessage& replaced) {
  const auto older = replaced_by(message);
  const bool replaces = older != messages_.end();
  const std::uint64_t freed = replaces ? older->second.payload.size() : 0;
  if (bytes_ - freed + message.payload.size() > bytes_max) return Added::kRefused;
  if (replaces) replaced = remove(older);
  insert(std::move(message));
  return replaces ? Added::kReplaced : Added::kQueued;
}

PacketQueue::Messages::iterator PacketQueue::find_next(std::uint64_t now_ns) {
  return std::find_if(messages_.begin(), messages_.end(),
                      [&](const auto& entry) { return entry.second.held_until_ns <= now_ns; });
}

LinkMessage* PacketQueue::next(std::uint64_t now_ns) {
  const auto found = find_next(now_ns);
  return found == messages_.end() ? nullptr : &found->second;
}

LinkMessage PacketQueue::repeat_next(std::uint64_t now_ns, std::uint64_t held_until_ns) {
  LinkMessage message = pop_next(now_ns);
  LinkMessage copy = message;
  message.packets_sent = 0;
  message.again = true;
  --(held_until_ns > 0 ? message.retransmissions : message.repeats);
  message.held_until_ns = held_until_ns;
  insert(std::move(message));
  return copy;
}

bool PacketQueue::finish(std::uint64_t number) {
  const auto found = std::find_if(messages_.begin(), messages_.end(),
                                  [&](const auto& entry) { return entry.second.number == number; });
  if (found == messages_.end()) return false;
  found->second.repeats = found->second.retransmissions = 0;
  if (found->second.packets_sent > 0) return false;
  remove(found);
  return true;
}

std::vector<const LinkMessage*> PacketQueue::messages() const {
  std::vector<std::pair<std::uint64_t, const LinkMessage*>> ordered;
  for (const auto& [place, message] : messages_) ordered.emplace_back(place.order, &message);
  std::sort(ordered.begin(), ordered.end());
  std::vector<const LinkMessage*> found;
  for (const auto& entry : ordered) found.push_back(entry.second);
  return found;
}

void PacketQueue::insert(LinkMessage message) {
  const Place place{message.priority, next_order_++};
  bytes_ += message.payload.size();
  numbers_.insert(message.number);
  if (message.replaces) replaceable_.insert(place);
  if (message.deadline_ns > 0 && message.packets_sent == 0) deadlines_.emplace(message.deadline_ns, place);
  messages_.emplace(place, std::move(message));
}

LinkMessage PacketQueue::remove(Messages::iterator from) {
  LinkMessage taken = std::move(from->second);
  bytes_ -= taken.payload.size();
  numbers_.erase(taken.number);
  replaceable_.erase(from->first);
  deadlines_.erase({taken.deadline_ns, from->first});
  messages_.erase(from);
  return taken;
}

PacketQueue::Messages::iterator PacketQueue::replaced_by(const LinkMessage& message) {
  auto oldest = messages_.end();
  if (!message.replaces) return oldest;
  for (const Place& place : replaceable_) {
    const auto other = messages_.find(place);
    const LinkMessage& held = other->second;
    if (held.packets_sent > 0 || held.topic != message.topic || held.from != message.from || held.to != message.to) {
      continue;
    }
    if (oldest == messages_.end() || place.order < oldest->first.order) oldest = other;
  }
  return oldest;
}

void PacketQueue::exchange_state(StateArchive& archive) {
  std::vector<LinkMessage> all;
  for (const LinkMessage* message : messages()) all.push_back(*message);
  archive.list(all, [&](LinkMessage& message) { message.exchange_state(archive); });
  *this = PacketQueue();
  for (LinkMessage& message : all) insert(std::move(message));
}

}  // namespace uwsim
