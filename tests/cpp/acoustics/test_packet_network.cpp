#include "uwsim/acoustics/modem/packet_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "acoustics/ring_network.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

TEST(PacketNetwork, AMessageArrivesAfterItsTravelTimeAndItsDuration) {
  Network run(aloha());
  const auto topic = run.network.topic("key");
  run.network.send(0, message(1, topic, "hello"), 0);
  run.run(1);
  ASSERT_EQ(run.network.deliveries().size(), 1u);
  const LinkDelivery& got = run.network.deliveries().front();
  EXPECT_EQ(got.payload, "hello");
  EXPECT_EQ(got.arrived_ns, 100000000u + 8 * 9 * 1000000u);
  EXPECT_EQ(run.network.quality(0, 1).heard_ns, got.arrived_ns);
}

TEST(PacketNetwork, ALongMessageArrivesWithItsLastPacketOrNotAtAll) {
  Network run(aloha(), 2, {{0.6, 0.7, 1}});  // loses the second packet
  const auto topic = run.network.topic("picture");
  run.network.send(0, message(1, topic, std::string(150, 'a')), 0);
  run.run(3);
  EXPECT_EQ(run.network.deliveries().size(), 0u);
  EXPECT_EQ(run.network.counts(topic, 0).lost[static_cast<std::size_t>(Loss::kFault)], 1u);
  EXPECT_EQ(run.network.counts(topic, 0).bytes_sent, 150u);
  run.network.send(0, message(1, topic, std::string(150, 'b')), run.now_ns);
  run.run(3);
  ASSERT_EQ(run.network.deliveries().size(), 1u);
  EXPECT_EQ(run.network.deliveries().front().payload, std::string(150, 'b'));
}

TEST(PacketNetwork, UrgentMessagesOvertakeAndNewerOnesReplaceAndOldOnesExpire) {
  Network run(aloha());
  const auto slow = run.network.topic("slow"), urgent = run.network.topic("urgent");
  LinkMessage first = message(1, slow, std::string(180, 's'));
  first.priority = 3;
  run.network.send(0, first, 0);
  run.run(0.1);  // its first packet is in flight
  for (const char* text : {"1", "2"}) {
    LinkMessage command = message(1, urgent, text);
    command.replaces = true;
    run.network.send(0, command, run.now_ns);
  }
  LinkMessage stale = message(1, slow, "stale");
  stale.priority = 4;
  stale.deadline_ns = run.now_ns + 500000000;
  run.network.send(0, stale, run.now_ns);
  run.run(5);
  ASSERT_EQ(run.network.deliveries().size(), 2u);
  EXPECT_EQ(run.network.deliveries()[0].payload, "2");
  EXPECT_EQ(run.network.counts(urgent, 0).replaced, 1u);
  EXPECT_EQ(run.network.counts(slow, 0).late, 1u);
  EXPECT_EQ(run.network.waiting_messages(0), 0u);
}

TEST(PacketNetwork, AFullQueueRefuses) {
  ModemSpec modem = aloha();
  modem.queue_bytes = 100;
  Network run(modem);
  const auto topic = run.network.topic("t");
  EXPECT_TRUE(run.network.send(0, message(1, topic, std::string(60, 'x')), 0));
  EXPECT_FALSE(run.network.send(0, message(1, topic, std::string(60, 'x')), 0));
  EXPECT_EQ(run.network.counts(topic, 0).refused, 1u);
}

TEST(PacketNetwork, WhoSendsIsDeaf) {
  Network run(aloha());
  const auto topic = run.network.topic("t");
  run.network.send(0, message(1, topic, std::string(60, 'x')), 0);
  run.network.send(1, message(0, topic, std::string(60, 'x')), 0);
  run.run(2);
  EXPECT_EQ(run.sum(topic).lost[static_cast<std::size_t>(Loss::kDeaf)], 2u);
}

TEST(PacketNetwork, TooFastIsFatalAndIsReported) {
  Network run(aloha());
  run.medium.closing_m_s = -6;
  const auto topic = run.network.topic("t");
  run.network.send(0, message(1, topic, "x"), 0);
  run.run(1);
  EXPECT_EQ(run.sum(topic).lost[static_cast<std::size_t>(Loss::kDoppler)], 1u);
  EXPECT_EQ(run.network.quality(0, 1).closing_m_s, -6);
}

TEST(PacketNetwork, PureAlohaDeliversGExpMinus2GAndPeaksNear18Percent) {
  // Abramson 1970: S = G exp(-2 G). Many nodes are used, so that few of them have two packets at a time.
  const double packet_s = aloha().packet_s(60);
  for (const double load : {0.1, 0.25, 0.5, 1.0}) {
    const RandomLoad random{.modem = aloha(), .step_s = 0.02};  // a 25th of a packet
    const TopicCounts counts = random.counts(41, load / 40 / packet_s, 6000);
    EXPECT_NEAR(static_cast<double>(counts.delivered) * packet_s / 6000, load * std::exp(-2 * load), 0.012) << load;
  }
}

TEST(PacketNetwork, TdmaNeverCollides) {
  const TopicCounts all = RandomLoad{.modem = tdma()}.counts(5, 2.0, 600);  // far more than the channel can carry
  EXPECT_EQ(all.lost[static_cast<std::size_t>(Loss::kCollision)] + all.lost[static_cast<std::size_t>(Loss::kDeaf)], 0u);
  // Four of five slots are used, one packet each.
  EXPECT_NEAR(static_cast<double>(all.delivered), 600 / 0.75 * 0.8, 6);
}

TEST(PacketNetwork, AQueueWaitsAsLongAsPollaczekAndKhinchineSay) {
  // M/D/1: mean wait in the queue = rho / (2 (1 - rho)) x service time.
  ModemSpec cable = aloha();
  cable.kind = LinkKind::kCable;
  const double service = cable.packet_s(60);
  for (const double rho : {0.3, 0.6, 0.8}) {
    const TopicCounts counts = RandomLoad{.modem = cable, .delay_s = 0}.counts(2, rho / service, 40000);
    const double load = static_cast<double>(counts.given) * service / 40000;  // actual value of the random draws
    const double mean = counts.delay_s / static_cast<double>(counts.delivered) - service;
    EXPECT_NEAR(mean / (load / (2 * (1 - load)) * service), 1, 0.05) << "rho = " << rho;
  }
}

TEST(PacketNetwork, NoiseLosesWhatTheCurveSays) {
  Network run(aloha());
  run.medium.signal_db = 77;
  run.medium.noise_db = 74;
  const auto topic = run.network.topic("t");
  const double expected = packet_loss(run.network.modem(), run.medium.receive(0, 1), -300, 2);
  ASSERT_GT(expected, 0.1);
  ASSERT_LT(expected, 0.9);
  const int count = 4000;
  for (int k = 0; k < count; ++k) {
    run.network.send(0, message(1, topic, "ab"), run.now_ns);
    run.run(0.2);
  }
  const double lost = static_cast<double>(run.sum(topic).lost[static_cast<std::size_t>(Loss::kNoise)]) / count;
  EXPECT_NEAR(lost, expected, 4 * std::sqrt(expected * (1 - expected) / count));
}

/// On this ring, a packet of 9 bytes is received from 0.1 s to 0.172 s.
TEST(PacketNetwork, APacketInTheWaterWhenABlackoutBeginsIsLostAndOneThatArrivesAfterItIsNot) {
  const auto delivered = [](const LinkFault& fault) {
    Network run(aloha(), 2, {fault});
    run.network.send(0, message(1, run.network.topic("t"), "12345"), 0);
    run.run(1);
    return run.network.deliveries().size();
  };
  EXPECT_EQ(delivered({0, 0.1, 1}), 1u);      // ends before reception begins, although the packet was sent meanwhile
  EXPECT_EQ(delivered({0, 0.101, 1}), 0u);    // overlaps the start of reception
  EXPECT_EQ(delivered({0.171, 0.5, 1}), 0u);  // overlaps the end of reception, long after the packet was sent
  EXPECT_EQ(delivered({0.172, 0.5, 1}), 1u);  // begins when the packet has arrived
  EXPECT_EQ(delivered({0.12, 0.13, 1}), 0u);  // overlaps the middle of reception
}

TEST(PacketNetwork, ACutNodeNeitherHearsNorIsHeardUntilItIsJoinedAgain) {
  Network run(aloha(), 3);
  const auto topic = run.network.topic("t");
  run.network.send(0, message(1, topic, "in the water"), 0);
  run.run(0.12);
  run.network.cut_off(1, true, run.now_ns);
  EXPECT_EQ(run.network.fault_loss(1, 0, run.now_ns), 1);
  EXPECT_EQ(run.network.fault_loss(2, 0, run.now_ns), 0);
  run.run(0.5);
  run.network.send(1, message(0, topic, "from it"), run.now_ns);
  run.run(0.5);
  run.network.send(2, message(0, topic, "from another"), run.now_ns);
  run.run(0.5);
  EXPECT_EQ(run.sum(topic).lost[static_cast<std::size_t>(Loss::kFault)], 2u);
  ASSERT_EQ(run.network.deliveries().size(), 1u);
  run.network.cut_off(1, false, run.now_ns);
  run.network.send(0, message(1, topic, "afterwards"), run.now_ns);
  run.run(0.5);
  EXPECT_EQ(run.network.deliveries().back().payload, "afterwards");
  EXPECT_EQ(run.network.fault_loss(1, 0, run.now_ns), 0);
}

TEST(PacketNetwork, AMessageThatIsRepeatedArrivesOnceAndIsLostOnlyIfAllCopiesAre) {
  constexpr int kMessages = 1500;
  const double loss = 0.4;
  Network run(aloha(), 2, {{0, 1e6, loss}});
  const auto topic = run.network.topic("command");
  for (int k = 0; k < kMessages; ++k) {
    LinkMessage command = message(1, topic, "1234");
    command.repeats = 2;
    run.network.send(0, command, run.now_ns);
    run.run(0.5);
  }
  const TopicCounts& counts = run.network.counts(topic, 0);
  EXPECT_EQ(counts.sent, static_cast<std::uint64_t>(kMessages));
  EXPECT_EQ(counts.bytes_sent, 3u * 4u * kMessages);
  const std::uint64_t lost = counts.lost[static_cast<std::size_t>(Loss::kFault)];
  EXPECT_EQ(counts.delivered + lost, counts.sent);
  const double expected = loss * loss * loss;
  EXPECT_NEAR(static_cast<double>(lost) / kMessages, expected, 4 * std::sqrt(expected * (1 - expected) / kMessages));
}

TEST(PacketNetwork, ANewerCommandEndsTheRepeatsOfTheOlderWhichIsThenLostOrNot) {
  Network run(aloha(), 2, {{0, 0.5, 1}});  // loses everything that arrives first
  const auto topic = run.network.topic("command");
  LinkMessage command = message(1, topic, std::string(60, '1'));  // 0.512 s
  command.repeats = 5;
  command.replaces = true;
  run.network.send(0, command, 0);
  run.run(0.4);  // in flight, and waiting to be repeated
  command.payload = "newer";
  run.network.send(0, command, run.now_ns);
  run.run(5);
  EXPECT_EQ(run.network.counts(topic, 0).sent, 2u);
  EXPECT_EQ(run.network.counts(topic, 0).replaced, 0u);  // it has been sent
  EXPECT_EQ(run.network.counts(topic, 0).lost[static_cast<std::size_t>(Loss::kFault)], 1u);
  ASSERT_EQ(run.network.deliveries().size(), 1u);
  EXPECT_EQ(run.network.deliveries()[0].payload, "newer");
}

TEST(PacketNetwork, RestoredItGoesOnToTheSameEnd) {
  const auto load = [](Network& run, int messages) {
    const std::uint64_t topic = run.network.topic("load");
    for (int k = 0; k < messages; ++k) {
      LinkMessage one = message(0, topic, std::string(100, 'x'));
      one.repeats = static_cast<std::uint64_t>(k % 3);
      run.network.send(1 + static_cast<std::size_t>(k % 5), one, run.now_ns);
      run.run(0.3);
    }
  };
  ModemSpec modem = aloha();
  modem.backoff_s = 0.5;
  Network whole(modem, 6);
  load(whole, 40);
  whole.network.cut_off(3, true, whole.now_ns);
  StateArchive saved;
  whole.network.exchange_state(saved);
  Network other(modem, 6);
  StateArchive restored(saved.bytes());
  other.network.exchange_state(restored);
  restored.finish();
  other.now_ns = whole.now_ns;
  load(whole, 40);
  load(other, 40);
  StateArchive a, b;
  whole.network.exchange_state(a);
  other.network.exchange_state(b);
  EXPECT_EQ(a.bytes(), b.bytes());
}

TEST(PacketNetwork, RefusesASlotThatHoldsNoPacket) {
  ModemSpec modem = tdma();
  modem.slot_s = 0.5;
  EXPECT_THROW(PacketNetwork(modem, 2, {}, 0, kStep_ns), InvalidValue);
}

}  // namespace
}  // namespace uwsim
