// A stand-in for a node of ROS 2 with rmw_fastrtps, its default middleware: the same DDS, the same names of topics and
// types, the same codec. It subscribes and publishes as its arguments say, and prints what it saw as lines of JSON.
//
//   fast_dds_peer DOMAIN SECONDS [alone | at ADDRESS] [sub TOPIC TYPE reliable|best_effort volatile|latched]...
//   [pub TOPIC HZ]... [call SERVICE TYPE COUNT|HEX]... [graph]
//
// call: calls a service with an empty request, or once with the request in HEX, as rmw_fastrtps does
// (rmw_request.cpp, rmw_response.cpp, rmw_client.cpp): once both ends are matched, COUNT requests that name the reader
// of their responses; prints the responses that are its. alone: it does not name the other side, which must find it.
// at: it uses the network of this address, and multicast, instead of the loopback. pub: geometry_msgs/Twist whose
// linear.x counts up. A line of standard input ends it before the time.

#include <poll.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fastcdr/exceptions/Exception.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <zlib.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>

#include "messages.h"

namespace fd = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kParticipantsMax = 32;  // of one host that are looked for, as ROS 2 has it

std::mutex output;

std::string guid_text(const rtps::GUID_t& guid) {
  char text[40];
  int at = 0;
  for (auto byte : guid.guidPrefix.value) at += std::snprintf(text + at, sizeof text - at, "%02x", byte);
  for (auto byte : guid.entityId.value) at += std::snprintf(text + at, sizeof text - at, "%02x", byte);
  return text;
}

/// Prints who else is there.
class Graph : public fd::DomainParticipantListener {
 public:
  bool prints = false;

  void on_publisher_discovery(fd::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    if (info.status == rtps::WriterDiscoveryInfo::DISCOVERED_WRITER) print("writer", info.info);
  }
  void on_subscriber_discovery(fd::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override {
    if (info.status == rtps::ReaderDiscoveryInfo::DISCOVERED_READER) print("reader", info.info);
  }

 private:
  template <typename Info>
  void print(const char* kind, const Info& info) {
    if (!prints) return;
    const std::string user(info.m_qos.m_userData.begin(), info.m_qos.m_userData.end());
    const std::lock_guard lock(output);
    std::printf("{\"endpoint\":\"%s\",\"topic\":\"%s\",\"type\":\"%s\",\"user_data\":\"%s\",\"guid\":\"%s\"}\n", kind,
                info.topicName().c_str(), info.typeName().c_str(), user.c_str(), guid_text(info.guid()).c_str());
  }
};

/// Takes what a topic says and prints each message's checksum and content.
class Subscription : public fd::DataReaderListener {
 public:
  Subscription(std::string topic, std::string type) : topic_(std::move(topic)), type_(std::move(type)) {}

  void on_data_available(fd::DataReader* reader) override {
    Payload payload;
    fd::SampleInfo info;
    while (reader->take_next_sample(&payload, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      const auto sum = crc32(0, payload.data(), static_cast<unsigned>(payload.size()));
      const std::string content = content_of(payload);
      timespec now{};
      clock_gettime(CLOCK_MONOTONIC, &now);
      const std::lock_guard lock(output);
      std::printf("{\"topic\":\"%s\",\"size\":%zu,\"crc32\":%lu,\"now_ns\":%lld%s%s}\n", topic_.c_str(), payload.size(),
                  sum, now.tv_sec * 1'000'000'000LL + now.tv_nsec, content.empty() ? "" : ",", content.c_str());
    }
  }

  void on_subscription_matched(fd::DataReader*, const fd::SubscriptionMatchedStatus& status) override {
    const std::lock_guard lock(output);
    std::printf("{\"matched\":\"%s\",\"count\":%d}\n", topic_.c_str(), status.current_count);
  }

 private:
  std::string content_of(const Payload& payload) const {
    try {
      return decoded(type_, payload);
    } catch (const eprosima::fastcdr::exception::Exception& error) {
      return "\"broken\":" + in_quotes(error.what());
    }
  }

  std::string topic_, type_;
};

fd::DomainParticipantQos participant_qos(bool alone, const std::string& address) {
  fd::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back(address);
  udp->non_blocking_send = true;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  const std::string enclave = "enclave=/;";
  qos.user_data().setValue({enclave.begin(), enclave.end()});
  if (!alone) {
    rtps::Locator_t locator;
    rtps::IPLocator::setIPv4(locator, "127.0.0.1");
    udp->maxInitialPeersRange = kParticipantsMax;
    qos.wire_protocol().builtin.initialPeersList.push_back(locator);
  }
  return qos;
}

/// Publishes a count at a rate until told to stop.
void publish(fd::DataWriter* writer, double hz, const std::atomic<bool>& stops) {
  auto next = Clock::now();
  for (int count = 0; !stops; ++count) {
    Payload payload = twist(1e-3 * count);
    writer->write(&payload);
    next += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / hz));
    std::this_thread::sleep_until(next);
  }
}

/// A client of a service. The next request follows each response.
class Client : public fd::DataReaderListener {
 public:
  Client(std::string service, const std::string& what) : service_(std::move(service)), request_(20) {
    request_[1] = 1;  // otherwise zeros, enough for the requests of our tests, which ignore more
    if (what.size() < 8) {
      left_ = std::stoi(what);
      return;
    }
    request_.clear();
    for (std::size_t i = 0; i + 1 < what.size(); i += 2)
      request_.push_back(static_cast<Payload::value_type>(std::stoi(what.substr(i, 2), nullptr, 16)));
  }

  fd::DataWriter* requests = nullptr;
  fd::DataReader* responses = nullptr;

  void send() {
    Payload request = request_;
    rtps::WriteParams params;
    params.related_sample_identity().writer_guid() = responses->guid();
    requests->write(&request, params);
    sent_ = params.sample_identity().sequence_number();
  }

  void on_data_available(fd::DataReader* reader) override {
    Payload payload;
    fd::SampleInfo info;
    while (reader->take_next_sample(&payload, &info) == ReturnCode_t::RETCODE_OK) {
      const auto& identity = info.related_sample_identity;
      if (!info.valid_data ||
          (identity.writer_guid() != responses->guid() && identity.writer_guid() != requests->guid()))
        continue;
      std::string hex;
      for (auto byte : payload) hex += "0123456789abcdef"[byte >> 4], hex += "0123456789abcdef"[byte & 15];
      {
        const std::lock_guard lock(output);
        std::printf("{\"service\":\"%s\",\"is_answer_of_last\":%s,\"hex\":\"%s\"}\n", service_.c_str(),
                    identity.sequence_number() == sent_ ? "true" : "false", hex.c_str());
      }
      if (--left_ > 0) send();
    }
  }

 private:
  std::string service_;
  Payload request_;
  int left_ = 1;
  rtps::SequenceNumber_t sent_;
};

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 2) return 2;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const double seconds = std::stod(words[1]);
  std::size_t at = 2;
  const bool alone = at < words.size() && words[at] == "alone";
  at += alone;
  std::string address = "127.0.0.1";
  const bool far = at + 1 < words.size() && words[at] == "at";
  if (far) address = words[at + 1], at += 2;

  Graph graph;
  for (const auto& word : words) graph.prints |= word == "graph";
  auto* participant = fd::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<std::uint32_t>(std::stoul(words[0])), participant_qos(alone || far, address), &graph,
      fd::StatusMask::none());
  if (participant == nullptr) return 1;
  auto* subscriber = participant->create_subscriber(fd::SUBSCRIBER_QOS_DEFAULT);
  auto* publisher = participant->create_publisher(fd::PUBLISHER_QOS_DEFAULT);

  auto topic = [&](const std::string& name, const std::string& type) {
    fd::TypeSupport(new RawType(type)).register_type(participant);
    return participant->create_topic(name, type, fd::TOPIC_QOS_DEFAULT);
  };
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  std::vector<std::unique_ptr<Client>> clients;
  std::vector<std::thread> threads;
  std::atomic<bool> stops{false};
  while (at < words.size()) {
    if (words[at] == "sub") {
      subscriptions.push_back(std::make_unique<Subscription>(words[at + 1], words[at + 2]));
      fd::DataReaderQos qos;
      qos.reliability().kind =
          words[at + 3] == "reliable" ? fd::RELIABLE_RELIABILITY_QOS : fd::BEST_EFFORT_RELIABILITY_QOS;
      qos.durability().kind =
          words[at + 4] == "latched" ? fd::TRANSIENT_LOCAL_DURABILITY_QOS : fd::VOLATILE_DURABILITY_QOS;
      qos.history().depth = 100;  // Fast DDS 2.9 fails an assertion when fragments meet a full history
      qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
      if (!subscriber->create_datareader(topic(words[at + 1], words[at + 2]), qos, subscriptions.back().get()))
        return 1;
      at += 5;
    } else if (words[at] == "pub") {
      fd::DataWriterQos qos;
      qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
      auto* writer = publisher->create_datawriter(topic(words[at + 1], "geometry_msgs::msg::dds_::Twist_"), qos);
      if (writer == nullptr) return 1;
      threads.emplace_back(publish, writer, std::stod(words[at + 2]), std::cref(stops));
      at += 3;
    } else if (words[at] == "call") {
      clients.push_back(std::make_unique<Client>(words[at + 1], words[at + 3]));
      fd::DataWriterQos asks;
      asks.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
      fd::DataReaderQos answers;
      answers.reliability().kind = fd::RELIABLE_RELIABILITY_QOS;
      answers.history().depth = 10;
      answers.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
      auto& client = *clients.back();
      client.responses = subscriber->create_datareader(
          topic("rr/" + words[at + 1] + "Reply", words[at + 2] + "_Response_"), answers, &client);
      client.requests =
          publisher->create_datawriter(topic("rq/" + words[at + 1] + "Request", words[at + 2] + "_Request_"), asks);
      if (client.requests == nullptr || client.responses == nullptr) return 1;
      threads.emplace_back([&client, &stops] {
        fd::PublicationMatchedStatus asked;
        fd::SubscriptionMatchedStatus answered;
        while (!stops && (asked.current_count == 0 || answered.current_count == 0)) {
          client.requests->get_publication_matched_status(asked);
          client.responses->get_subscription_matched_status(answered);
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        if (!stops) client.send();
      });
      at += 4;
    } else if (words[at] == "graph") {
      ++at;
    } else {
      return 2;
    }
  }
  pollfd input{0, POLLIN, 0};
  poll(&input, 1, static_cast<int>(1e3 * seconds));
  stops = true;
  for (auto& thread : threads) thread.join();
  participant->delete_contained_entities();
  fd::DomainParticipantFactory::get_instance()->delete_participant(participant);
  return 0;
}
