#include "live/line_output.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/json.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds patience_at_the_end{1000};
constexpr double least_latency_s = 1e-6;
constexpr std::array ending_signals = {SIGINT, SIGTERM, SIGHUP};
/// Event descriptor that the signal handler writes to; any thread may receive the signal.
std::atomic<int> noted_at = -1;

void note_signal(int) {
  const int saved = errno;
  const std::uint64_t one = 1;
  // Fails only if the counter is full, when the end has long been requested.
  [[maybe_unused]] const ssize_t written = ::write(noted_at, &one, sizeof one);
  errno = saved;
}

static_assert(std::endian::native == std::endian::little, "records are written as memory has them");

template <typename Number>
void append(std::string& out, const Number& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
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

bool Mailbox::put(ArrivedFrame frame) {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || frames_.size() < places_ || first_ <= 0; });
    if (closed_) return false;
    if (frames_.size() == places_) {
      frames_.pop_front();
      ++dropped_;
    }
    frames_.push_back(std::move(frame));
  }
  changed_.notify_all();
  return true;
}

Mailbox::Taken Mailbox::take(ArrivedFrame& frame, std::chrono::milliseconds patience) {
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return closed_ || !frames_.empty(); });
    if (frames_.empty()) return closed_ ? Taken::closed : Taken::nothing;
    frame = std::move(frames_.front());
    frames_.pop_front();
    --first_;
  }
  changed_.notify_all();
  return Taken::frame;
}

void Mailbox::close(bool now) {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    if (now) {
      dropped_ += frames_.size();
      frames_.clear();
    }
  }
  changed_.notify_all();
}

std::uint64_t Mailbox::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

void LatencyHistogram::add(double seconds) {
  const double place =
      classes_per_decade * std::log10(std::max(seconds, least_latency_s) / least_latency_s);
  const auto last = static_cast<double>(counts_.size() - 1);
  ++counts_[static_cast<std::size_t>(std::min(place, last))];
  ++count_;
  largest_s_ = std::max(largest_s_, seconds);
}

std::optional<double> LatencyHistogram::quantile_s(double share) const {
  if (count_ == 0) return std::nullopt;
  const std::uint64_t rank = nearest_rank(count_, share) + 1;
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    below += counts_[i];
    if (below < rank) continue;
    const double end =
        least_latency_s * std::pow(10, static_cast<double>(i + 1) / classes_per_decade);
    return std::min(end, largest_s_);
  }
  return largest_s_;
}

std::vector<std::uint64_t> LatencyHistogram::coarse(int per_decade) const {
  const auto width = static_cast<std::size_t>(classes_per_decade / per_decade);
  std::vector<std::uint64_t> out(counts_.size() / width);
  for (std::size_t i = 0; i < counts_.size(); ++i) out[i / width] += counts_[i];
  return out;
}

bool LineOutput::wait_for_reader() {
  if (!until_ && stop_.wait_to_write(STDOUT_FILENO)) return true;
  if (!until_) until_ = std::chrono::steady_clock::now() + patience_at_the_end;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  int ready = 0;
  do {
    const auto left =
        std::chrono::duration_cast<milliseconds>(*until_ - std::chrono::steady_clock::now());
    ready = ::poll(&output, 1, static_cast<int>(std::max(left, milliseconds(0)).count()));
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

void LineOutput::line(const nlohmann::json& value) {
  const std::string text = json_text(value) + "\n";
  for (std::size_t at = 0; open_ && at < text.size();) {
    const std::size_t most = std::min<std::size_t>(PIPE_BUF, text.size() - at);
    if (!wait_for_reader()) {
      open_ = false;
      return;
    }
    const ssize_t n = ::write(STDOUT_FILENO, text.data() + at, most);
    if (n > 0) {
      at += static_cast<std::size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      open_ = false;
      error_ = n < 0 && errno != EPIPE && errno != ECONNRESET ? errno : 0;
    }
  }
}

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

}  // namespace ertbench
