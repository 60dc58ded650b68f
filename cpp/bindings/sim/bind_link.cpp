#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/arrays.h"
#include "bindings/core/gil.h"
#include "bindings/sim/binders.h"
#include "uwsim/sim/link.h"

namespace uwsim::bindings {
namespace {

void bind_link_formulas(py::module_& m) {
  py::enum_<LinkKind>(m, "LinkKind")
      .value("CABLE", LinkKind::kCable)
      .value("IDEAL", LinkKind::kIdeal)
      .value("MODEM", LinkKind::kModem);
  py::enum_<MediumAccess>(m, "MediumAccess").value("ALOHA", MediumAccess::kAloha).value("TDMA", MediumAccess::kTdma);
  py::enum_<Modulation>(m, "Modulation").value("PSK", Modulation::kPsk).value("FSK", Modulation::kFsk);
  py::class_<ModemSpec>(m, "ModemSpec", "Parameters of a modem; see cpp/uwsim/acoustics/modem/modem_spec.h.")
      .def(py::init<>())
      .def_readwrite("kind", &ModemSpec::kind)
      .def_readwrite("bit_rate_bit_s", &ModemSpec::bit_rate_bit_s)
      .def_readwrite("preamble_s", &ModemSpec::preamble_s)
      .def_readwrite("packet_bytes", &ModemSpec::packet_bytes)
      .def_readwrite("header_bytes", &ModemSpec::header_bytes)
      .def_readwrite("latency_s", &ModemSpec::latency_s)
      .def_readwrite("frequency_hz", &ModemSpec::frequency_hz)
      .def_readwrite("bandwidth_hz", &ModemSpec::bandwidth_hz)
      .def_readwrite("source_level_db", &ModemSpec::source_level_db)
      .def_readwrite("receiver_noise_db_hz", &ModemSpec::receiver_noise_db_hz)
      .def_readwrite("modulation", &ModemSpec::modulation)
      .def_readwrite("fading", &ModemSpec::fading)
      .def_readwrite("coding_gain_db", &ModemSpec::coding_gain_db)
      .def_readwrite("multipath_window_s", &ModemSpec::multipath_window_s)
      .def_readwrite("symbol_s", &ModemSpec::symbol_s)
      .def_readwrite("speed_max_m_s", &ModemSpec::speed_max_m_s)
      .def_readwrite("access", &ModemSpec::access)
      .def_readwrite("slot_s", &ModemSpec::slot_s)
      .def_readwrite("guard_s", &ModemSpec::guard_s)
      .def_readwrite("backoff_s", &ModemSpec::backoff_s)
      .def_readwrite("queue_bytes", &ModemSpec::queue_bytes)
      .def_readwrite("retransmissions", &ModemSpec::retransmissions)
      .def_readwrite("acknowledgement_bytes", &ModemSpec::acknowledgement_bytes)
      .def("packet_s", &ModemSpec::packet_s, py::arg("bytes"), "Return the duration of a packet [s].")
      .def("check", &ModemSpec::check, "Raise ValueError naming modem.<field> if a parameter is invalid.");
  py::class_<LinkFault>(m, "LinkFault", "An interval in which packets are lost with some probability.")
      .def(py::init<double, double, double>(), py::arg("from_s"), py::arg("until_s"), py::arg("loss"))
      .def_readonly("from_s", &LinkFault::from_s)
      .def_readonly("until_s", &LinkFault::until_s)
      .def_readonly("loss", &LinkFault::loss);
  py::class_<LinkSpec>(m, "LinkSpec", "Parameters of the link between the station and the vehicles.")
      .def(py::init<>())
      .def_readwrite("modem", &LinkSpec::modem)
      .def_readwrite("station_transducer_world_m", &LinkSpec::station_transducer_world_m)
      .def_property(
          "wind_m_s", [](const LinkSpec& l) { return l.noise.wind_m_s; },
          [](LinkSpec& l, double value) { l.noise.wind_m_s = value; })
      .def_property(
          "shipping", [](const LinkSpec& l) { return l.noise.shipping; },
          [](LinkSpec& l, double value) { l.noise.shipping = value; })
      .def(
          "set_bottom",
          [](LinkSpec& l, double density_ratio, double speed_ratio, double attenuation_db_wavelength) {
            l.bottom = {density_ratio, speed_ratio, attenuation_db_wavelength};
          },
          py::arg("density_ratio"), py::arg("speed_ratio"), py::arg("attenuation_db_wavelength"))
      .def_readwrite("faults", &LinkSpec::faults);
}

/// Binds the link's physics as separate functions, for validation and plots.
void bind_link_physics(py::module_& m) {
  m.def("bit_error", &bit_error, py::arg("modulation"), py::arg("fading"), py::arg("gamma"));
  m.def("packet_error", &packet_error, py::arg("bit_error"), py::arg("bits"));
  m.def("surface_loss_db", &surface_loss_db, py::arg("frequency_hz"), py::arg("sound_speed_m_s"),
        py::arg("rms_height_m"), py::arg("grazing_rad"));
  m.def(
      "bottom_loss_db",
      [](double density_ratio, double speed_ratio, double attenuation_db_wavelength, double grazing_rad) {
        return bottom_loss_db({density_ratio, speed_ratio, attenuation_db_wavelength}, grazing_rad);
      },
      py::arg("density_ratio"), py::arg("speed_ratio"), py::arg("attenuation_db_wavelength"), py::arg("grazing_rad"));
  m.def(
      "ambient_noise_db_hz",
      [](double frequency_hz, double wind_m_s, double shipping) {
        return ambient_noise_db_hz(frequency_hz, {wind_m_s, shipping});
      },
      py::arg("frequency_hz"), py::arg("wind_m_s"), py::arg("shipping"));
  py::class_<LinkWater>(m, "LinkWater", "The propagation of sound between transducers.")
      .def(py::init<const LinkSpec&, const Water&>(), py::arg("spec"), py::arg("water"))
      .def(
          "receive",
          [](const LinkWater& water, const RayScene& scene, const py::object& from_m, const py::object& to_m) {
            const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
            return water.receive(scene, {as_vector3(from_m, "from_world_m"), zero},
                                 {as_vector3(to_m, "to_world_m"), zero});
          },
          py::arg("scene"), py::arg("from_world_m"), py::arg("to_world_m"),
          "Return how a packet would be received, between two points at rest.");
}

void bind_link_results(py::module_& m) {
  m.attr("RANGING_PING_BYTES") = PositionExchange::kPingBytes;
  py::class_<Reception>(m, "Reception", "How a packet reaches a receiver; levels in dB re 1 uPa.")
      .def_readonly("reached", &Reception::reached)
      .def_readonly("delay_s", &Reception::delay_s, "delay of the first arrival within 20 dB of the strongest")
      .def_readonly("signal_db", &Reception::signal_db)
      .def_readonly("noise_db", &Reception::noise_db, "within the band, including interference between symbols")
      .def_property_readonly("snr_db", &Reception::snr_db)
      .def_readonly("closing_m_s", &Reception::closing_m_s, "closing speed of the ends along the strongest arrival")
      .def_readonly("spread_s", &Reception::spread_s,
                    "from the first to the last arrival within 20 dB of the strongest")
      .def_readonly(
          "bed_departure", &Reception::bed_departure,
          "departure of the bed between the ends from the assumed flat bottom, as a fraction of its depth; 0 if no\n"
          "significant arrival has bounced off the bottom")
      .def_property_readonly(
          "bed_is_uneven", [](const Reception& heard) { return heard.bed_departure > kUnevenBed; },
          "whether the bed is too uneven for the assumed flat bottom: bed_departure is above 0.05")
      .def(
          "packet_loss",
          [](const Reception& heard, const ModemSpec& modem, std::uint64_t bytes) {
            return packet_loss(modem, heard, -300, bytes);
          },
          py::arg("modem"), py::arg("bytes"),
          "Return the probability that a packet with this many bytes is lost due to noise.");
  py::class_<LinkDelivery>(m, "LinkDelivery", "A message that has arrived. from, to: nodes; topic: an index.")
      .def_readonly("number", &LinkDelivery::number)
      .def_property_readonly("from_node", [](const LinkDelivery& d) { return d.from; })
      .def_property_readonly("to_node", [](const LinkDelivery& d) { return d.to; })
      .def_readonly("topic", &LinkDelivery::topic)
      .def_readonly("given_ns", &LinkDelivery::given_ns)
      .def_readonly("arrived_ns", &LinkDelivery::arrived_ns)
      .def_property_readonly("payload", [](const LinkDelivery& d) { return py::bytes(d.payload); });
  py::class_<TopicCounts>(m, "TopicCounts", "Outcomes of the messages that a node submitted on a topic.")
      .def_readonly("given", &TopicCounts::given)
      .def_readonly("replaced", &TopicCounts::replaced, "replaced by newer messages before they were sent")
      .def_readonly("refused", &TopicCounts::refused, "refused because the queue was full")
      .def_readonly("late", &TopicCounts::late, "dropped because the deadline passed before they could be sent")
      .def_readonly("sent", &TopicCounts::sent)
      .def_readonly("resent", &TopicCounts::resent, "retransmissions after a missing acknowledgement")
      .def_readonly("delivered", &TopicCounts::delivered)
      .def_readonly("bytes_sent", &TopicCounts::bytes_sent)
      .def_readonly("bytes_delivered", &TopicCounts::bytes_delivered)
      .def_readonly("delay_s", &TopicCounts::delay_s, "sum over all delivered messages")
      .def_property_readonly(
          "lost",
          [](const TopicCounts& c) {
            constexpr const char* kNames[kLossKinds] = {"none",    "unheard", "noise", "collision",
                                                        "sending", "doppler", "fault"};
            std::map<std::string, std::uint64_t> lost;
            for (std::size_t k = 1; k < kLossKinds; ++k) lost[kNames[k]] = c.lost[k];
            return lost;
          },
          "Lost messages by reason. sending: the receiver was sending at the time; unheard: there is no path.");
  py::class_<LinkQuality>(m, "LinkQuality", "The link quality that a node last observed for another.")
      .def_readonly("packets", &LinkQuality::packets)
      .def_readonly("packets_lost", &LinkQuality::packets_lost)
      .def_readonly("packets_uneven", &LinkQuality::packets_uneven,
                    "packets for which the bed was too uneven for the assumed flat bottom (Reception.bed_is_uneven)")
      .def_readonly("heard_ns", &LinkQuality::heard_ns, "when the last message arrived; 0 if none has")
      .def_readonly("delay_s", &LinkQuality::delay_s)
      .def_readonly("snr_db", &LinkQuality::snr_db)
      .def_readonly("closing_m_s", &LinkQuality::closing_m_s)
      .def_readonly("spread_s", &LinkQuality::spread_s);
}

}  // namespace

void bind_link(py::module_& m, py::class_<OwnedSimulation>& simulation) {
  bind_link_formulas(m);
  bind_link_results(m);
  bind_link_physics(m);
  simulation
      .def("set_link", &OwnedSimulation::set_link, py::arg("spec"),
           "Connect the station, node 0, and all vehicles, nodes 1 + index. May be called once. Raises ValueError.")
      .def(
          "link_topic",
          [](OwnedSimulation& o, const std::string& name) {
            return o.with([&](Simulation& s) { return s.link().topic(name); });
          },
          py::arg("name"), "Return the index of a topic, creating it if it is new.")
      .def("link_topics", [](OwnedSimulation& o) { return o.with([](Simulation& s) { return s.link().topics(); }); })
      .def(
          "link_send",
          [](OwnedSimulation& o, std::size_t from, std::uint64_t to, std::uint64_t topic, const py::bytes& payload,
             std::uint64_t priority, double lifetime_s, bool replaces, std::uint64_t repeats) {
            LinkMessage message;
            message.to = to;
            message.topic = topic;
            message.payload = payload;
            message.priority = priority;
            message.replaces = replaces;
            message.repeats = repeats;
            return o.with([&](Simulation& s) {
              if (lifetime_s > 0) message.deadline_ns = s.time_ns() + static_cast<std::uint64_t>(1e9 * lifetime_s);
              return s.link().send(from, std::move(message), s.time_ns());
            });
          },
          py::arg("from_node"), py::arg("to_node"), py::arg("topic"), py::arg("payload"), py::arg("priority") = 0,
          py::arg("lifetime_s") = 0.0, py::arg("replaces") = false, py::arg("repeats") = 0,
          "Queue a message now and return whether there was room. lifetime_s: time after which it is no longer\n"
          "sent; 0 for no limit. repeats: number of times that it is sent again. Raises ValueError.")
      .def(
          "link_deliveries",
          [](OwnedSimulation& o, std::uint64_t to, std::uint64_t after_ns) {
            return o.with([&](Simulation& s) {
              std::vector<LinkDelivery> found;
              for (const LinkDelivery& one : s.link().deliveries()) {
                if (one.to == to && one.arrived_ns > after_ns) found.push_back(one);
              }
              return found;
            });
          },
          py::arg("to_node"), py::arg("after_ns"),
          "Return the messages that arrived at a node after a time, oldest first; only the newest 512 of all\n"
          "nodes are kept.")
      .def(
          "link_counts",
          [](OwnedSimulation& o, std::uint64_t topic, std::size_t from) {
            return o.with([&](Simulation& s) {
              require(topic < s.link().topics().size() && from < s.link().nodes(), "link.topic", topic, "is unknown");
              return s.link().counts(topic, from);
            });
          },
          py::arg("topic"), py::arg("from_node"))
      .def(
          "link_quality",
          [](OwnedSimulation& o, std::size_t from, std::size_t at) {
            return o.with([&](Simulation& s) {
              require(from < s.link().nodes() && at < s.link().nodes(), "link.node", std::max(from, at), "is unknown");
              return s.link().quality(from, at);
            });
          },
          py::arg("from_node"), py::arg("at_node"))
      .def(
          "link_reception",
          [](OwnedSimulation& o, std::size_t from, std::size_t to) {
            return o.with([&](Simulation& s) { return s.link_reception(from, to); });
          },
          py::arg("from_node"), py::arg("to_node"), "Return how a packet sent now would be received.")
      .def(
          "link_cut_off",
          [](OwnedSimulation& o, std::size_t node, bool is_cut_off) {
            o.with([&](Simulation& s) { s.link().cut_off(node, is_cut_off, s.time_ns()); });
          },
          py::arg("node"), py::arg("is_cut_off"), "Disconnect a node from now on, or reconnect it.")
      .def(
          "link_fault_loss",
          [](OwnedSimulation& o, std::size_t from, std::size_t to) {
            return o.with([&](Simulation& s) { return s.link().fault_loss(from, to, s.time_ns()); });
          },
          py::arg("from_node"), py::arg("to_node"), "Return the probability that a fault destroys a packet sent now.")
      .def(
          "link_waiting",
          [](OwnedSimulation& o, std::size_t node) {
            return o.with([&](Simulation& s) {
              require(node < s.link().nodes(), "link.node", node, "is unknown");
              return std::pair(s.link().waiting_messages(node), s.link().waiting_bytes(node));
            });
          },
          py::arg("node"), "Return (messages, bytes) in a node's queue.")
      .def(
          "link_sending_s",
          [](OwnedSimulation& o) { return o.with([](Simulation& s) { return s.link().sending_s(); }); },
          "Return the total time that nodes have been sending [s].")
      .def(
          "link_next_arrival_ns",
          [](OwnedSimulation& o) {
            return o.with([](Simulation& s) { return s.link().next_arrival_ns(s.time_ns()); });
          },
          "Return a lower bound for the time at which the next message arrives.");
}

}  // namespace uwsim::bindings
