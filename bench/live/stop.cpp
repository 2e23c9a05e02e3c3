#include "bench/live/stop.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <system_error>

namespace ertbench {
namespace {

constexpr std::array ending_signals = {SIGINT, SIGTERM, SIGHUP};
/// Where a signal is noted, in whatever thread it arrives: libraries have threads of their own.
std::atomic<int> noted_at = -1;

void note_signal(int) {
  const int saved = errno;
  const std::uint64_t one = 1;
  // It can only fail where it has been asked often before.
  [[maybe_unused]] const ssize_t written = ::write(noted_at, &one, sizeof one);
  errno = saved;
}

}  // namespace

Stop::Stop() : asked_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (asked_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  noted_at = asked_;
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  for (const int signal : ending_signals) ::sigaction(signal, &action, nullptr);
}

Stop::~Stop() {
  for (const int signal : ending_signals) std::signal(signal, SIG_DFL);
  noted_at = -1;
  ::close(asked_);
}

void Stop::stop() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(asked_, &one, sizeof one);
}

bool Stop::stopped() const { return wait(-1, {}) == Event::stopped; }

Stop::Event Stop::wait(int descriptor, std::chrono::nanoseconds patience) const {
  std::array<pollfd, 2> both = {{{asked_, POLLIN, 0}, {descriptor, POLLIN, 0}}};
  const auto left = std::max(patience, std::chrono::nanoseconds(0));
  const timespec time{static_cast<time_t>(left.count() / 1'000'000'000),
                      static_cast<long>(left.count() % 1'000'000'000)};
  const int ready = ::ppoll(both.data(), both.size(), &time, nullptr);
  if (ready <= 0) return Event::time;
  return both[0].revents != 0 ? Event::stopped : Event::readable;
}

bool Stop::wait_to_write(int descriptor) const {
  std::array<pollfd, 2> both = {{{asked_, POLLIN, 0}, {descriptor, POLLOUT, 0}}};
  while (::poll(both.data(), both.size(), -1) < 0 && errno == EINTR) {
  }
  return both[1].revents != 0;
}

}  // namespace ertbench
