#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "acoustics/ring_network.h"

namespace uwsim {
namespace {

/// Three standard deviations of the share of n independent events of probability p.
double three_sigma(double p, double n) { return 3 * std::sqrt(p * (1 - p) / n); }

TEST(Acknowledgements, NRetransmissionsDeliverAllButTheMessagesThatAreLostEachTime) {
  constexpr double kLoss = 0.4;
  for (const std::uint64_t n : {0u, 1u, 3u}) {
    NetworkTrial trial = trial_of(tdma(), 2, 0.1, 12000);
    trial.loss = kLoss;
    trial.modem.retransmissions = n;
    const TopicCounts counts = run_trial(trial);
    const double expected = 1 - std::pow(kLoss, static_cast<double>(n + 1)), given = static_cast<double>(counts.given);
    EXPECT_GT(given, 1000);
    EXPECT_NEAR(static_cast<double>(counts.delivered) / given, expected, three_sigma(expected, given)) << n;
    // Each attempt fails if the message or its acknowledgement is lost; with a further one per message after the first
    const double failed = 1 - (1 - kLoss) * (1 - kLoss);
    double resent = 0;
    for (std::uint64_t k = 1; k <= n; ++k) resent += std::pow(failed, static_cast<double>(k));
    EXPECT_NEAR(static_cast<double>(counts.resent) / given, resent, 0.1 * resent) << n;
  }
}

TEST(Acknowledgements, OneThatIsLostCausesADuplicateThatIsDiscarded) {
  ModemSpec modem = aloha();
  modem.retransmissions = 2;
  modem.guard_s = 0.2;
  // "hello" arrives at 0.172 s, and its acknowledgement between 0.275 and 0.307 s
  for (const bool loses : {false, true}) {
    Network run(modem, 2, loses ? std::vector<LinkFault>{{0.28, 0.3, 1}} : std::vector<LinkFault>{});
    const auto topic = run.network.topic("key");
    run.network.send(0, message(1, topic, "hello"), 0);
    run.run(0.3);
    EXPECT_EQ(run.network.waiting_messages(0), 1u) << "until it is acknowledged";
    run.run(0.1);
    EXPECT_EQ(run.network.waiting_messages(0), loses ? 1u : 0u);
    run.run(5);
    EXPECT_EQ(run.network.waiting_messages(0), 0u);
    EXPECT_EQ(run.network.counts(topic, 0).resent, loses ? 1u : 0u);
    EXPECT_EQ(run.network.counts(topic, 0).delivered, 1u);
    EXPECT_EQ(run.network.deliveries().size(), 1u);
    EXPECT_EQ(run.network.quality(1, 0).heard_ns, 0u) << "an acknowledgement does not end a silence";
  }
}

TEST(Acknowledgements, ANewerMessageEndsTheRetransmissionsOfTheOneItReplaces) {
  ModemSpec modem = aloha();
  modem.retransmissions = 9;
  Network run(modem, 2, {{0, 2, 1}});
  const auto topic = run.network.topic("state");
  for (const char* text : {"old", "new"}) {
    LinkMessage one = message(1, topic, text);
    one.replaces = true;
    run.network.send(0, one, run.now_ns);
    run.run(1);
  }
  run.run(30);
  ASSERT_EQ(run.network.deliveries().size(), 1u);
  EXPECT_EQ(run.network.deliveries()[0].payload, "new");
  EXPECT_EQ(run.network.counts(topic, 0).lost[static_cast<std::size_t>(Loss::kFault)], 1u);
}

TEST(Relays, EachHopTakesItsTravelTimeAndItsDuration) {
  ModemSpec modem = aloha();
  Network run(modem, 4, {}, {0, 0, 1, 2});
  const auto topic = run.network.topic("key");
  run.network.send(3, message(0, topic, "up"), 0);
  run.run(2);
  run.network.send(0, message(3, topic, "down"), run.now_ns);
  const std::uint64_t sent_ns = run.now_ns;
  run.run(2);
  ASSERT_EQ(run.network.deliveries().size(), 2u);
  // 6 and 8 bytes with their headers; a relay forwards at the step that follows
  const auto over_three = [](std::uint64_t hop_ns) {
    return 2 * ((hop_ns + kStep_ns - 1) / kStep_ns * kStep_ns) + hop_ns;
  };
  EXPECT_EQ(run.network.deliveries()[0].arrived_ns, over_three(148000000));
  EXPECT_EQ(run.network.deliveries()[0].from, 3u);
  EXPECT_EQ(run.network.deliveries()[1].arrived_ns, sent_ns + over_three(164000000));
  EXPECT_EQ(run.network.deliveries()[1].to, 3u);
  EXPECT_NEAR(run.network.quality(3, 0).delay_s, 3 * run.medium.delay_s, 1e-12);
  EXPECT_EQ(run.network.counts(topic, 3).sent, 1u);
  EXPECT_EQ(run.network.counts(topic, 1).sent, 0u) << "counted for the node that submitted it";
}

TEST(Relays, MessagesGoUpToTheFirstCommonNodeAndDown) {
  const Network run(aloha(), 7, {}, {0, 0, 1, 2, 1, 0, 5});  // 3 - 2 - 1, 4 - 1, 6 - 5
  const auto route = [&](std::size_t at, std::size_t to) {
    std::vector<std::size_t> hops;
    while (at != to) hops.push_back(at = run.network.next_hop(at, to));
    return hops;
  };
  EXPECT_EQ(route(3, 0), (std::vector<std::size_t>{2, 1, 0}));
  EXPECT_EQ(route(0, 3), (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_EQ(route(3, 4), (std::vector<std::size_t>{2, 1, 4}));
  EXPECT_EQ(route(3, 6), (std::vector<std::size_t>{2, 1, 5, 6})) << "the station is no relay";
  EXPECT_EQ(route(1, 5), (std::vector<std::size_t>{5}));
  EXPECT_THROW(Network(aloha(), 3, {}, {0, 2, 1}), InvalidValue) << "a circle";
  EXPECT_THROW(Network(aloha(), 3, {}, {0, 3, 0}), InvalidValue);
}

TEST(Relays, WhatARelayCannotHoldIsLostThere) {
  ModemSpec modem = aloha();
  modem.queue_bytes = 100;
  Network run(modem, 3, {}, {0, 0, 1});
  const auto topic = run.network.topic("t");
  run.network.send(1, message(2, topic, std::string(90, 'x')), 0);  // fills the relay's own queue for a second
  run.network.send(2, message(0, topic, std::string(20, 'y')), 0);
  run.run(5);
  const TopicCounts& counts = run.network.counts(topic, 2);
  EXPECT_EQ(counts.delivered + counts.lost[static_cast<std::size_t>(Loss::kRelay)] +
                counts.lost[static_cast<std::size_t>(Loss::kDeaf)],
            1u);
  EXPECT_EQ(counts.delivered, 0u);
}

}  // namespace
}  // namespace uwsim
