#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "uwsim/acoustics/modem/modem_spec.h"
#include "uwsim/acoustics/modem/packet_queue.h"
#include "uwsim/acoustics/modem/reception.h"
#include "uwsim/core/random.h"

namespace uwsim {

/// An interval in which packets are lost with some probability, whatever the water does; 1 is a blackout. It affects
/// every packet whose reception overlaps it, including those that were under way when it began.
struct LinkFault {
  double from_s = 0;
  double until_s = 0;
  double loss = 1;
};

/// Reasons for the loss of a packet.
enum class Loss { kNone, kUnheard, kNoise, kCollision, kDeaf, kDoppler, kFault };
inline constexpr std::size_t kLossKinds = 7;

/// The surroundings of a network: where its nodes are now.
class LinkMedium {
 public:
  virtual ~LinkMedium() = default;
  /// Computes how a packet sent now reaches another node.
  virtual Reception hear(std::size_t from, std::size_t to) const = 0;
  /// The approximate delay [s] and level [dB re 1 uPa] of the direct path, for a packet that is not addressed to that
  /// node.
  virtual std::array<double, 2> overhear(std::size_t from, std::size_t to) const = 0;
};

/// A message that has arrived.
struct LinkDelivery {
  std::uint64_t number = 0, from = 0, to = 0, topic = 0, given_ns = 0, arrived_ns = 0;
  std::string payload;
  void exchange_state(StateArchive& archive);
};

/// The fate of the messages on a topic that a node submitted. replaced: by newer ones before they were sent. refused:
/// the queue was full. late: the deadline passed before they could be sent. lost: by why their first lost packet was
/// lost. Bytes count payloads only.
struct TopicCounts {
  std::uint64_t given = 0, replaced = 0, refused = 0, late = 0, sent = 0, delivered = 0;
  std::uint64_t bytes_sent = 0, bytes_delivered = 0;
  std::array<std::uint64_t, kLossKinds> lost{};
  double delay_s = 0;  ///< sum over all delivered messages, from submission to arrival
  TopicCounts& operator+=(const TopicCounts& other);
  void exchange_state(StateArchive& archive);
};

/// The link quality that one node last observed from another.
struct LinkQuality {
  std::uint64_t packets = 0, packets_lost = 0;
  std::uint64_t heard_ns = 0;                                     ///< when the last message arrived; 0: none has yet
  double delay_s = 0, snr_db = 0, closing_m_s = 0, spread_s = 0;  ///< of the last packet, lost or not
  void exchange_state(StateArchive& archive);
};

/// Nodes that exchange messages over one shared channel, packet by packet, in simulated time. Every node receives every
/// packet. Nodes are half-duplex: deaf while they send. Packets that overlap at a receiver are noise to each other.
/// There are no acknowledgements: a message whose packets do not all arrive is lost unless it is repeated (`repeats`)
/// and a repeat arrives; a receiver drops further copies. A message arrives with its last packet. Draws are keyed by
/// the number of the packet. Motion during a packet's flight is neglected.
class PacketNetwork {
 public:
  PacketNetwork(const ModemSpec& modem, std::size_t nodes, std::vector<LinkFault> faults, std::uint64_t seed,
                std::uint64_t step_ns);

  const ModemSpec& modem() const { return modem_; }
  std::size_t nodes() const { return nodes_.size(); }
  /// The index of a topic, for send() and counts().
  std::uint64_t topic(const std::string& name);
  const std::vector<std::string>& topics() const { return topics_; }
  /// The fate of the messages on a topic that a node submitted.
  const TopicCounts& counts(std::uint64_t topic, std::size_t from) const { return counts_[topic][from]; }

  /// Queues a message from a node at a given time; returns whether there was room. Throws InvalidValue for an unknown
  /// node.
  bool send(std::size_t from, LinkMessage message, std::uint64_t now_ns);
  /// Starts sending whatever may be sent in the step that begins now.
  void transmit(std::uint64_t now_ns, const LinkMedium& medium);
  /// Receives everything that has arrived by now; returns the number of messages.
  std::size_t receive(std::uint64_t now_ns);
  /// Cuts a node off from now on, or reconnects it: a node that is cut off neither sends nor receives packets.
  void cut_off(std::size_t node, bool is_cut_off, std::uint64_t now_ns);
  /// The probability that a fault destroys a packet between the nodes now.
  double fault_loss(std::size_t from, std::size_t to, std::uint64_t now_ns) const;
  /// How long a node may have to wait for its own turn and the others' [s].
  double longest_wait_s() const;
  /// The earliest time at which a message may arrive, as far as is known; none arrives before it.
  std::uint64_t next_arrival_ns(std::uint64_t now_ns) const;

  /// The newest messages that arrived, in order of arrival.
  const std::deque<LinkDelivery>& deliveries() const { return deliveries_; }
  /// The link quality that `at` last observed from `from`.
  const LinkQuality& quality(std::size_t from, std::size_t at) const { return quality_[from * nodes_.size() + at]; }
  std::uint64_t waiting_messages(std::size_t node) const { return nodes_[node].queue.size(); }
  std::uint64_t waiting_bytes(std::size_t node) const { return nodes_[node].queue.bytes(); }
  /// For how long any node has been sending, in total.
  double sending_s() const { return sending_s_; }

  void exchange_state(StateArchive& archive);

 private:
  struct Node {
    PacketQueue queue;
    std::uint64_t may_send_ns = 0;       // ALOHA: end of the wait
    bool waits = false;                  // ALOHA: the wait before the next packet has been drawn
    std::uint64_t sending_until_ns = 0;  // end of its newest packet
  };
  /// A packet on its way to its addressee.
  struct Flight {
    std::uint64_t packet = 0, from = 0, at = 0, starts_ns = 0, ends_ns = 0;
    Reception heard;
    LinkMessage message;  // its payload is set with the last packet only
    std::uint64_t bytes = 0;
    bool is_last = false, deaf = false;
    bool is_copy = false;  // one of several copies of its message
    void exchange_state(StateArchive& archive);
  };
  /// A packet as a node receives it, addressed to it or not: noise to all others there. There are many of these.
  struct Sound {
    std::uint64_t packet = 0, at = 0, starts_ns = 0, ends_ns = 0;
    double level_db = 0;
    void exchange_state(StateArchive& archive);
  };
  /// A message of which some packets have arrived. fate: of its first lost packet, if any, in its newest copy. before:
  /// of the copy before. delivered: whether a copy was.
  struct Partial {
    std::uint64_t number = 0, fate = 0, before = 0;
    bool delivered = false;
    void exchange_state(StateArchive& archive);
  };
  /// An interval in which a node is cut off.
  struct Outage {
    std::uint64_t node = 0, from_ns = 0, until_ns = 0;
  };

  bool may_send(std::size_t index, std::uint64_t now_ns, std::uint64_t length_ns, std::uint64_t& start_ns);
  void send_packet(std::size_t index, std::uint64_t start_ns, std::uint64_t length_ns, const LinkMedium& medium);
  void let_others_hear(const Flight& flight, std::uint64_t start_ns, std::uint64_t length_ns, const LinkMedium& medium);
  void deafen(std::size_t index, std::uint64_t from_ns, std::uint64_t until_ns);
  void arrive(const Flight& flight);
  void finish_copy(const Flight& flight, Partial& known);
  void drop_repeat(std::size_t from, const LinkMessage& message);
  bool more_to_come(const Flight& flight) const;
  Partial& partial(std::uint64_t number);
  void forget(std::uint64_t number);
  Loss fate(const Flight& flight) const;
  bool struck_by_fault(const Flight& flight) const;
  double interference_db(const Flight& flight) const;
  void finish(const Flight& flight, Loss fate);
  void forget_sounds(std::uint64_t now_ns);
  void forget_outages(std::uint64_t now_ns);
  void check() const;
  void check(const LinkMessage& message, std::size_t from) const;
  void check_ends(const char* what, std::size_t from, std::size_t to) const;
  void check_topic(std::uint64_t topic) const;

  ModemSpec modem_;
  std::vector<LinkFault> faults_;
  std::vector<Outage> outages_;
  std::uint64_t step_ns_;
  RandomStream losses_, waits_;
  std::vector<Node> nodes_;
  std::vector<std::string> topics_;
  std::vector<std::vector<TopicCounts>> counts_;  // by topic, then by sender
  std::vector<LinkQuality> quality_;
  std::vector<Flight> flights_;
  std::vector<Sound> sounds_;  // by packet
  std::vector<Partial> partials_;
  std::deque<LinkDelivery> deliveries_;
  std::vector<std::size_t> arrived_;  // kept between steps to reuse its memory, like the next one
  std::vector<std::uint64_t> first_start_ns_;
  std::uint64_t next_message_ = 0, next_packet_ = 0;
  std::uint64_t next_end_ns_ = ~std::uint64_t{0};  // earliest end of a flight
  std::uint64_t waiting_ = 0;                      // number of messages in all queues
  std::uint64_t busy_until_ns_ = 0;
  double sending_s_ = 0;
  std::uint64_t delivered_ = 0;  // number of messages since construction
};

}  // namespace uwsim
