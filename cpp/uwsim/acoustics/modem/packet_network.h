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

/// An interval in which packets are lost with a given probability, in addition to losses in the water; a probability of
/// 1 is a blackout. It affects every packet whose reception overlaps it, including those in flight when it began.
struct LinkFault {
  double from_s = 0;
  double until_s = 0;
  double loss = 1;
};

/// The reason for the loss of a packet.
enum class Loss { kNone, kUnheard, kNoise, kCollision, kDeaf, kDoppler, kFault };
inline constexpr std::size_t kLossKinds = 7;

/// Provides the acoustics between a network's nodes at their present positions.
class LinkMedium {
 public:
  virtual ~LinkMedium() = default;
  /// Returns how a packet sent now would reach another node.
  virtual Reception receive(std::size_t from, std::size_t to) const = 0;
  /// Returns the approximate delay [s] and level [dB re 1 uPa] along the direct path, for a packet that is not
  /// addressed to that node.
  virtual std::array<double, 2> interference(std::size_t from, std::size_t to) const = 0;
};

/// A message that has arrived.
struct LinkDelivery {
  std::uint64_t number = 0, from = 0, to = 0, topic = 0, given_ns = 0, arrived_ns = 0;
  std::string payload;
  void exchange_state(StateArchive& archive);
};

/// Counts the outcomes of the messages that a node submitted on a topic. replaced: superseded by newer messages before
/// they were sent. refused: rejected because the queue was full. late: not sent before their deadline. lost: counted by
/// the reason that applied to their first lost packet. resent: retransmissions. Byte counts include the payloads of all
/// transmissions, without headers.
struct TopicCounts {
  std::uint64_t given = 0, replaced = 0, refused = 0, late = 0, sent = 0, delivered = 0, resent = 0;
  std::uint64_t bytes_sent = 0, bytes_delivered = 0;
  std::array<std::uint64_t, kLossKinds> lost{};
  double delay_s = 0;  ///< time from submission to arrival, summed over all delivered messages
  void exchange_state(StateArchive& archive);
};

/// The quality of the link from one node to another, as last observed by the receiver.
struct LinkQuality {
  std::uint64_t packets = 0, packets_lost = 0;
  std::uint64_t packets_uneven = 0;                               ///< packets that were received over an uneven bed
  std::uint64_t heard_ns = 0;                                     ///< when the last message arrived; 0 if none has
  double delay_s = 0, snr_db = 0, closing_m_s = 0, spread_s = 0;  ///< of the last packet, lost or not
  void exchange_state(StateArchive& archive);
};

/// Nodes that exchange messages over one shared channel, packet by packet, in simulated time. Every node receives every
/// packet. Nodes are half-duplex: they cannot receive while they send. Packets that overlap at a receiver are noise to
/// each other. A message with a lost packet is lost unless the whole message is sent again. Repeats (`repeats`) are
/// sent in any case; a modem with retransmissions sends the message again if no acknowledgement has arrived within
/// timeout_s() of the end of its last packet. Every copy that arrives is acknowledged by a packet, which waits for its
/// turn, takes up air time and may be lost, too. If p is the probability that all packets of a copy arrive, n
/// retransmissions deliver 1 - (1 - p)^(n + 1) of the messages. Receivers discard duplicates. A message arrives when
/// its last packet does.
///
/// Random draws are keyed by packet number. Motion during a packet's flight is neglected.
class PacketNetwork {
 public:
  /// Throws InvalidValue.
  PacketNetwork(const ModemSpec& modem, std::size_t nodes, std::vector<LinkFault> faults, std::uint64_t seed,
                std::uint64_t step_ns);

  const ModemSpec& modem() const { return modem_; }
  std::size_t nodes() const { return nodes_.size(); }
  /// Returns the index of a topic, for send() and counts().
  std::uint64_t topic(const std::string& name);
  const std::vector<std::string>& topics() const { return topics_; }
  /// Returns the counts for a topic and the node that submitted the messages.
  const TopicCounts& counts(std::uint64_t topic, std::size_t from) const { return counts_[topic][from]; }

  /// Queues a message from a node; returns false if its queue is full. Throws InvalidValue for an unknown node.
  bool send(std::size_t from, LinkMessage message, std::uint64_t now_ns);
  /// Starts sending all packets that may be sent in the step that begins now.
  void transmit(std::uint64_t now_ns, const LinkMedium& medium);
  /// Receives everything that has arrived by now; returns the number of messages.
  std::size_t receive(std::uint64_t now_ns);
  /// Disconnects a node from now on, or reconnects it. A disconnected node neither sends nor receives packets.
  void cut_off(std::size_t node, bool is_cut_off, std::uint64_t now_ns);
  /// The probability that a fault destroys a packet sent between these nodes now.
  double fault_loss(std::size_t from, std::size_t to, std::uint64_t now_ns) const;
  /// The longest time that a node may have to wait for its turn to send [s].
  double longest_wait_s() const;
  /// The time to wait for an acknowledgement [s]: the wait for a turn, its packet, twice the modem's guard time, and
  /// two steps.
  double timeout_s() const;
  /// A lower bound for the time at which the next message arrives.
  std::uint64_t next_arrival_ns(std::uint64_t now_ns) const;

  /// The newest messages that arrived, in order of arrival.
  const std::deque<LinkDelivery>& deliveries() const { return deliveries_; }
  /// The quality of the link from node `from`, as last observed by node `at`.
  const LinkQuality& quality(std::size_t from, std::size_t at) const { return quality_[from * nodes_.size() + at]; }
  std::uint64_t waiting_messages(std::size_t node) const { return nodes_[node].queue.size(); }
  std::uint64_t waiting_bytes(std::size_t node) const { return nodes_[node].queue.bytes(); }
  /// The total time that nodes have been sending [s].
  double sending_s() const { return sending_s_; }

  /// Saves or restores the network.
  void exchange_state(StateArchive& archive);
  /// The version of the bytes of exchange_state().
  static constexpr std::uint64_t kLayout = 3;

 private:
  struct Node {
    PacketQueue queue;
    std::uint64_t may_send_ns = 0;       // ALOHA: end of the random wait
    bool waits = false;                  // ALOHA: whether the wait before the next packet has been drawn
    std::uint64_t sending_until_ns = 0;  // end of the newest packet
  };
  /// A packet in flight to its addressee.
  struct Flight {
    std::uint64_t packet = 0, from = 0, at = 0, starts_ns = 0, ends_ns = 0;
    Reception heard;
    LinkMessage message;  // its payload is set only with the last packet
    std::uint64_t bytes = 0;
    bool is_last = false, deaf = false;
    bool is_copy = false;  // one of several copies of its message
    void exchange_state(StateArchive& archive);
  };
  /// A packet as received by a node, whether or not it is addressed to it; it is noise to all other packets there.
  /// There are many of these, so the struct is small.
  struct Sound {
    std::uint64_t packet = 0, at = 0, starts_ns = 0, ends_ns = 0;
    double level_db = 0;
    void exchange_state(StateArchive& archive);
  };
  /// A message of which some packets have arrived. fate: the reason for the first lost packet of its newest copy, if
  /// any. before: the same for the previous copy. delivered: whether any copy has been delivered.
  struct Partial {
    std::uint64_t number = 0;  // of the message
    std::uint64_t fate = 0, before = 0;
    bool delivered = false;
    void exchange_state(StateArchive& archive);
  };
  /// An interval in which a node is disconnected.
  struct Outage {
    std::uint64_t node = 0, from_ns = 0, until_ns = 0;
  };

  bool may_send(std::size_t index, std::uint64_t now_ns, std::uint64_t length_ns, std::uint64_t& start_ns);
  void send_packet(std::size_t index, std::uint64_t now_ns, std::uint64_t start_ns, std::uint64_t length_ns,
                   const LinkMedium& medium);
  void add_interference(const Flight& flight, std::uint64_t start_ns, std::uint64_t length_ns,
                        const LinkMedium& medium);
  void deafen(std::size_t index, std::uint64_t from_ns, std::uint64_t until_ns);
  void arrive(const Flight& flight);
  void finish_copy(const Flight& flight, Partial& known);
  void drop_repeat(const LinkMessage& message);
  bool more_to_come(const Flight& flight) const;
  Partial& partial(std::uint64_t number);
  void forget(std::uint64_t number);
  void acknowledge(const Flight& flight);
  void acknowledged(std::size_t from, std::uint64_t number);
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
  std::uint64_t acknowledgements_ = 0;  // their topic
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
  std::vector<std::size_t> arrived_;  // kept between steps to reuse its memory, as is the next member
  std::vector<std::uint64_t> first_start_ns_;
  std::uint64_t next_message_ = 0, next_packet_ = 0;
  std::uint64_t next_end_ns_ = ~std::uint64_t{0};  // earliest end of a flight
  std::uint64_t waiting_ = 0;                      // number of messages in all queues
  std::uint64_t busy_until_ns_ = 0;
  double sending_s_ = 0;
  std::uint64_t delivered_ = 0;  // number of messages since construction
};

}  // namespace uwsim
