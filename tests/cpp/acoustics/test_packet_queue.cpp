#include "uwsim/acoustics/modem/packet_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace uwsim {
namespace {

/// A reference implementation of the queue's rules in which each operation examines every message.
class PlainQueue {
 public:
  std::vector<LinkMessage> messages;  // in order of submission

  PacketQueue::Added add(const LinkMessage& message, std::uint64_t bytes_max) {
    const auto older = std::find_if(messages.begin(), messages.end(), [&](const LinkMessage& other) {
      return message.replaces && other.replaces && other.packets_sent == 0 && other.topic == message.topic &&
             other.to == message.to;
    });
    std::uint64_t bytes = message.payload.size();
    for (const LinkMessage& other : messages) bytes += other.payload.size();
    const bool replaces = older != messages.end();
    if (replaces) bytes -= older->payload.size();
    if (bytes > bytes_max) return PacketQueue::Added::kRefused;
    if (replaces) messages.erase(older);
    messages.push_back(message);
    return replaces ? PacketQueue::Added::kReplaced : PacketQueue::Added::kQueued;
  }
  std::vector<LinkMessage>::iterator front() {
    return std::min_element(messages.begin(), messages.end(),
                            [](const auto& a, const auto& b) { return a.priority < b.priority; });
  }
  std::vector<std::uint64_t> expire(std::uint64_t now_ns) {
    std::vector<std::uint64_t> numbers;
    std::erase_if(messages, [&](const LinkMessage& message) {
      const bool gone = message.deadline_ns > 0 && message.packets_sent == 0 && now_ns >= message.deadline_ns;
      if (gone) numbers.push_back(message.number);
      return gone;
    });
    return numbers;
  }
};

std::vector<std::uint64_t> numbers_of(const PacketQueue& queue) {
  std::vector<std::uint64_t> numbers;
  for (const LinkMessage* message : queue.messages()) numbers.push_back(message->number);
  return numbers;
}

TEST(PacketQueue, ItFollowsThePlainRulesThroughRandomOperations) {
  constexpr std::uint64_t kBytes = 400;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const auto draw = [&](unsigned below) { return std::uint64_t{random() % below}; };
    PacketQueue queue;
    PlainQueue plain;
    for (std::uint64_t k = 1; k < 2000; ++k) {
      switch (draw(6)) {
        case 0:
        case 1: {
          LinkMessage message;
          message.number = k;
          message.to = draw(2);
          message.topic = draw(2);
          message.priority = draw(3);
          message.deadline_ns = draw(2) * (k + draw(100));
          message.replaces = draw(2) == 0;
          message.repeats = draw(3);
          message.payload.assign(draw(40), 'x');
          LinkMessage replaced;
          EXPECT_EQ(queue.add(message, kBytes, replaced), plain.add(message, kBytes));
          break;
        }
        case 2: {
          std::vector<std::uint64_t> gone;
          queue.expire(k, [&](const LinkMessage& message) { gone.push_back(message.number); });
          std::sort(gone.begin(), gone.end());
          std::vector<std::uint64_t> expected = plain.expire(k);
          std::sort(expected.begin(), expected.end());
          EXPECT_EQ(gone, expected);
          break;
        }
        default: {
          if (queue.empty()) break;
          const auto front = plain.front();
          EXPECT_EQ(queue.next(k)->number, front->number);
          if (draw(2) == 0) {
            ++queue.next(k)->packets_sent;
            ++front->packets_sent;
          } else if (front->repeats > 0) {
            queue.repeat_next(k, 0);
            front->packets_sent = 0;
            --front->repeats;
            std::rotate(front, front + 1, plain.messages.end());
          } else {
            EXPECT_EQ(queue.pop_next(k).number, front->number);
            plain.messages.erase(front);
          }
        }
      }
      std::vector<std::uint64_t> expected;
      std::uint64_t bytes = 0;
      for (const LinkMessage& message : plain.messages) {
        expected.push_back(message.number);
        bytes += message.payload.size();
        EXPECT_TRUE(queue.holds(message.number));
      }
      ASSERT_EQ(numbers_of(queue), expected) << "seed " << seed << ", operation " << k;
      ASSERT_EQ(queue.bytes(), bytes);
    }
  }
}

TEST(PacketQueue, AHeldMessageIsPassedOverUntilItsTimeAndMayBeFinishedBefore) {
  PacketQueue queue;
  LinkMessage replaced;
  for (const std::uint64_t number : {1u, 2u}) {
    LinkMessage message;
    message.number = number;
    message.retransmissions = 1;
    queue.add(message, 100, replaced);
  }
  EXPECT_EQ(queue.repeat_next(0, 50).number, 1u);
  EXPECT_EQ(queue.repeat_next(0, 60).number, 2u);
  EXPECT_EQ(queue.next(49), nullptr);
  EXPECT_EQ(queue.next(50)->number, 1u);
  EXPECT_TRUE(queue.finish(1));
  EXPECT_FALSE(queue.finish(1));
  EXPECT_EQ(queue.next(59), nullptr);
  EXPECT_EQ(queue.pop_next(60).retransmissions, 0u);
  EXPECT_TRUE(queue.empty());
}

// Regression test: when each operation examined all messages, this took more than a minute.
TEST(PacketQueue, AQueueOfAHundredThousandMessagesIsFilledAndEmptied) {
  PacketQueue queue;
  LinkMessage replaced;
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    LinkMessage message;
    message.number = k;
    message.deadline_ns = 1'000'000 + k;
    message.payload.assign(64, 'x');
    ASSERT_EQ(queue.add(message, 10'000'000, replaced), PacketQueue::Added::kQueued);
  }
  for (std::uint64_t k = 0; k < 50'000; ++k) ASSERT_EQ(queue.pop_next(0).number, k);
  std::uint64_t late = 0;
  for (std::uint64_t now_ns = 1'000'000; now_ns < 1'100'000; ++now_ns) {
    queue.expire(now_ns, [&](const LinkMessage&) { ++late; });
  }
  EXPECT_EQ(late, 50'000u);
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace uwsim
