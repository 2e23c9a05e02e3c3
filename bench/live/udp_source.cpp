#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "bench/live/live_source.h"
#include "bench/live/stop.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t most_datagram_bytes = 65536;
constexpr int receive_buffer_bytes = 1 << 20;

/// A frame a datagram.
class UdpSource final : public LiveSource {
 public:
  UdpSource(int descriptor, int channels, FrameFormat format)
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
    if (n < 0) return;  // a checksum that was wrong, say: the datagram is gone already
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

}  // namespace

std::unique_ptr<LiveSource> open_udp(const InputPlace& place, int channels, FrameFormat format) {
  const std::string name =
      "--input udp://" + printable(place.name) + ":" + std::to_string(place.port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error =
          ::getaddrinfo(place.name.c_str(), std::to_string(place.port).c_str(), &hints, &found);
      error != 0) {
    throw InputError(name + ": " + ::gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> address(found, ::freeaddrinfo);
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

}  // namespace ertbench
