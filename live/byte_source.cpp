#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <tuple>
#include <utility>

#include "core/errors.h"
#include "core/text.h"
#include "live/line_output.h"
#include "live/live_source.h"

namespace ertbench {
namespace {

/// After a pause this long within a binary frame the rest of that frame is taken to be lost.
constexpr std::chrono::milliseconds pause_of_sender{200};

/// A stream of bytes behind a descriptor.
class ByteSource final : public LiveSource {
 public:
  ByteSource(int descriptor, bool owned, std::string name, FrameColumns channels,
             FrameFormat format)
      : descriptor_(descriptor), owned_(owned), name_(std::move(name)), parser_(channels, format) {}
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  ~ByteSource() override {
    if (owned_) ::close(descriptor_);
  }

  bool can_wait() const override { return !owned_; }

  std::string run(FrameSink& sink, Stop& stop) override {
    std::array<char, 65536> bytes{};
    while (true) {
      switch (stop.wait(descriptor_, pause_of_sender)) {
        case Stop::Event::stopped:
          return "";
        case Stop::Event::time:
          parser_.pause(sink);
          continue;
        case Stop::Event::readable:
          break;
      }
      const ssize_t n = ::read(descriptor_, bytes.data(), bytes.size());
      if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (n > 0) {
        parser_.feed({bytes.data(), static_cast<std::size_t>(n)}, sink);
        continue;
      }
      const std::string why = n == 0 ? "" : std::string(": ") + std::strerror(errno);
      parser_.end(sink);
      if (!owned_ && n == 0) return "the input ended";
      throw InputError(name_ + ": is gone" + why + "; connect the sender again and start anew");
    }
  }

 private:
  int descriptor_;
  bool owned_;
  std::string name_;
  FrameParser parser_;
};

speed_t speed_of(int baud) {
  constexpr std::pair<int, speed_t> speeds[] = {
      {9600, B9600},       {19200, B19200},     {38400, B38400},     {57600, B57600},
      {115200, B115200},   {230400, B230400},   {460800, B460800},   {500000, B500000},
      {921600, B921600},   {1000000, B1000000}, {2000000, B2000000}, {3000000, B3000000},
      {4000000, B4000000},
  };
  std::string known;
  for (const auto& [number, speed] : speeds) {
    if (number == baud) return speed;
    known.append(known.empty() ? "" : ", ").append(std::to_string(number));
  }
  throw InputError("--input: no baud rate of " + std::to_string(baud) + "; there are " + known);
}

/// Removes the number behind the last '@' from `text` and returns it; nothing if there is none.
std::optional<double> number_behind_at(std::string& text) {
  const auto at = text.rfind('@');
  if (at == std::string::npos || at + 1 == text.size()) return std::nullopt;
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + at + 1, end, value);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  text.resize(at);
  return value;
}

constexpr std::size_t most_datagram_bytes = 65536;
constexpr int receive_buffer_bytes = 1 << 20;

/// Reads one frame from each datagram.
class UdpSource final : public LiveSource {
 public:
  UdpSource(int descriptor, FrameColumns channels, FrameFormat format)
      : descriptor_(descriptor), parser_(channels, format) {}
  UdpSource(const UdpSource&) = delete;
  UdpSource& operator=(const UdpSource&) = delete;
  ~UdpSource() override { ::close(descriptor_); }

  std::uint64_t lost_before() const override { return lost_; }

  std::string run(FrameSink& sink, Stop& stop) override {
    while (true) {
      const Stop::Event event = stop.wait(descriptor_, std::chrono::seconds(1));
      if (event == Stop::Event::stopped) return "";
      if (event == Stop::Event::readable) receive(sink);
    }
  }

 private:
  void receive(FrameSink& sink) {
    iovec place{bytes_.data(), bytes_.size()};
    alignas(cmsghdr) std::array<char, 256> control{};
    msghdr message{};
    message.msg_iov = &place;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t n = ::recvmsg(descriptor_, &message, MSG_DONTWAIT);
    if (n < 0) return;  // a wrong checksum, for example: the datagram is already discarded
    for (cmsghdr* one = CMSG_FIRSTHDR(&message); one; one = CMSG_NXTHDR(&message, one)) {
      if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SO_RXQ_OVFL) continue;
      std::uint32_t lost = 0;
      std::memcpy(&lost, CMSG_DATA(one), sizeof lost);
      lost_ = lost;
    }
    if ((message.msg_flags & MSG_TRUNC) != 0) return sink.damaged(Damage::length);
    parser_.datagram({bytes_.data(), static_cast<std::size_t>(n)}, sink);
  }

  int descriptor_;
  FrameParser parser_;
  std::array<char, most_datagram_bytes> bytes_{};
  std::atomic<std::uint64_t> lost_ = 0;
};

using Address = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

/// Of datagrams; `flags` as for getaddrinfo. Throws InputError that begins with `place`.
Address address_of(const std::string& host, int port, int flags, const std::string& place) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (error != 0) throw InputError(place + ::gai_strerror(error));
  return {found, ::freeaddrinfo};
}

}  // namespace

std::unique_ptr<LiveSource> open_standard_input(FrameColumns channels, FrameFormat format) {
  if (::isatty(STDIN_FILENO) == 1) {
    throw InputError("--input -: standard input is a terminal; pipe frames into the program");
  }
  return std::make_unique<ByteSource>(STDIN_FILENO, false, "standard input", channels, format);
}

std::unique_ptr<LiveSource> open_serial(const InputPlace& place, FrameColumns channels,
                                        FrameFormat format) {
  const speed_t speed = speed_of(place.baud);
  const std::string name = printable_path(place.name);
  const int descriptor = ::open(place.name.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    throw InputError(name + ": cannot be opened: " + std::strerror(errno) +
                     "; is it connected, and are you in the group dialout?");
  }
  auto source = std::make_unique<ByteSource>(descriptor, true, name, channels, format);
  termios line{};
  if (::tcgetattr(descriptor, &line) != 0) throw InputError(name + ": is no serial line");
  ::cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  ::cfsetspeed(&line, speed);
  if (::tcsetattr(descriptor, TCSANOW, &line) != 0) {
    throw InputError(name + ": refuses raw mode at " + std::to_string(place.baud) +
                     " baud: " + std::strerror(errno));
  }
  return source;
}

std::pair<std::string, int> host_and_port(const std::string& text, const std::string& option) {
  const auto colon = text.rfind(':');
  int port = -1;
  if (colon != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + colon + 1, end, port);
    if (read.ec != std::errc() || read.ptr != end) port = -1;
  }
  if (port < 0 || port > 65535 || colon == 0) {
    throw InputError(option +
                     ": must be HOST:PORT with a port up to 65535, \"127.0.0.1:8080\", got \"" +
                     printable(text) + "\"");
  }
  std::string host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return {host, port};
}

InputPlace input_place(const std::string& text) {
  InputPlace place;
  if (text == "-") return place;
  const auto behind = [&](std::string_view scheme) { return text.substr(scheme.size()); };
  if (text.starts_with("udp://")) {
    place.kind = InputPlace::Kind::udp;
    std::tie(place.name, place.port) = host_and_port(behind("udp://"), "--input");
    return place;
  }
  if (text.starts_with("serial:")) {
    place.kind = InputPlace::Kind::serial;
    place.name = behind("serial:");
    if (const auto baud = number_behind_at(place.name)) {
      if (!(*baud >= 1 && *baud <= 1e8))
        throw InputError("--input: no such baud rate in " + printable(text));
      place.baud = static_cast<int>(*baud);
    }
    return place;
  }
  if (text.starts_with("replay:")) {
    place.kind = InputPlace::Kind::replay;
    place.name = behind("replay:");
    place.rate = number_behind_at(place.name);
    if (place.rate && !(*place.rate > 0 && *place.rate <= 1e6)) {
      throw InputError("--input: the rate behind '@' must be > 0 and at most 1e6 frames/s, got " +
                       number_text(*place.rate));
    }
    return place;
  }
  throw InputError(
      "--input: must be -, udp://HOST:PORT, serial:DEVICE[@BAUD] or "
      "replay:FILE.h5[@RATE], got \"" +
      printable(text) + "\"");
}

std::unique_ptr<LiveSource> open_udp(const InputPlace& place, FrameColumns channels,
                                     FrameFormat format) {
  const std::string name =
      "--input udp://" + printable(place.name) + ":" + std::to_string(place.port);
  const Address found = address_of(place.name, place.port, AI_PASSIVE, name + ": ");
  const int descriptor = ::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) throw InputError(name + ": " + std::strerror(errno));
  auto source = std::make_unique<UdpSource>(descriptor, channels, format);
  const int yes = 1;
  ::setsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof(int));
  ::setsockopt(descriptor, SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes);
  if (::bind(descriptor, found->ai_addr, found->ai_addrlen) != 0) {
    throw InputError(name + ": cannot be listened at: " + std::strerror(errno) +
                     "; name an address of this machine and a port that is free");
  }
  return source;
}

DatagramSender::DatagramSender(const std::string& address) {
  constexpr std::string_view scheme = "udp://";
  if (!address.starts_with(scheme)) {
    throw InputError("--send: must be udp://HOST:PORT, got \"" + printable(address) + "\"");
  }
  const auto [host, port] = host_and_port(address.substr(scheme.size()), "--send");
  const std::string name = "--send " + printable(address) + ": ";
  const Address found = address_of(host, port, 0, name);
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
