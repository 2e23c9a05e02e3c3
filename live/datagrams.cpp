#include "live/datagrams.h"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>

#include "core/errors.h"
#include "core/text.h"
#include "live/live_source.h"

namespace ertbench {
namespace {

static_assert(std::endian::native == std::endian::little, "records are written as memory has them");

template <typename Number>
void append(std::string& out, const Number& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string binary_record(const LiveAnswer& answer, const Sensor& sensor, std::uint64_t frame,
                          double time_s, double latency_s) {
  const std::vector<ContactReading>& contacts = answer.reading.contacts;
  const Eigen::Vector2d centre = sensor.sheet->unit_mm() * sensor.sheet->bounds().center();
  double strength = 0;
  for (const ContactReading& one : contacts) strength += one.strength;
  std::string out = "ERTC";
  append(out, std::uint16_t{1});
  append(out, static_cast<std::uint16_t>(contacts.size()));
  append(out, frame);
  append(out, time_s);
  append(out, static_cast<float>(latency_s));
  append(out, static_cast<std::uint8_t>(answer.report.status));
  append(out, static_cast<std::uint8_t>(answer.report.reasons));
  append(out, std::uint16_t{0});
  append(out, static_cast<std::uint64_t>(answer.report.dead));
  for (const ContactReading& one : contacts) {
    const double force =
        answer.force_N && strength > 0 ? *answer.force_N * one.strength / strength : std::nan("");
    for (const double number : {one.place_mm.x() - centre.x(), one.place_mm.y() - centre.y(),
                                one.strength, one.peak, one.area_mm2, force}) {
      append(out, static_cast<float>(number));
    }
  }
  return out;
}

DatagramSender::DatagramSender(const std::string& address) {
  constexpr std::string_view scheme = "udp://";
  if (!address.starts_with(scheme)) {
    throw InputError("--send: must be udp://HOST:PORT, got \"" + printable(address) + "\"");
  }
  const auto [host, port] = host_and_port(address.substr(scheme.size()), "--send");
  const std::string name = "--send " + printable(address) + ": ";
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
      error != 0) {
    throw InputError(name + ::gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
  descriptor_ = ::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor_ < 0 || ::connect(descriptor_, found->ai_addr, found->ai_addrlen) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    throw InputError(name + std::strerror(error));
  }
}

DatagramSender::~DatagramSender() { ::close(descriptor_); }

void DatagramSender::send(const std::string& bytes) const {
  // A refusal by the last one's receiver is told by the next call, and is no fault of this one.
  [[maybe_unused]] const ssize_t sent =
      ::send(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace ertbench
