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
    ModemSpec modem = tdma();
    modem.retransmissions = n;
    const TopicCounts counts = RandomLoad{.modem = modem, .loss = kLoss}.counts(2, 0.1, 12000);
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

}  // namespace
}  // namespace uwsim
