#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "bench/live/live_source.h"
#include "bench/live/stop.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// A sender that stops within a binary frame for so long has lost the rest of it.
constexpr std::chrono::milliseconds pause_of_sender{200};

/// A stream of bytes behind a descriptor.
class ByteSource final : public LiveSource {
 public:
  ByteSource(int descriptor, bool owned, std::string name, int channels, FrameFormat format)
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

}  // namespace

std::unique_ptr<LiveSource> open_standard_input(int channels, FrameFormat format) {
  if (::isatty(STDIN_FILENO) == 1) {
    throw InputError("--input -: standard input is a terminal; pipe frames into the program");
  }
  return std::make_unique<ByteSource>(STDIN_FILENO, false, "standard input", channels, format);
}

std::unique_ptr<LiveSource> open_serial(const InputPlace& place, int channels, FrameFormat format) {
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

}  // namespace ertbench
