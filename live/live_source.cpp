#include "live/live_source.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/seconds.h"
#include "frames/text_lines.h"
#include "live/line_output.h"

namespace ertbench {
namespace {

/// Enough bytes to tell text from doubles, some of which are not printable.
constexpr std::size_t bytes_to_detect = 32;
/// Longest accepted line, for each channel: a number takes two dozen.
constexpr std::size_t most_line_bytes_per_channel = 64;

bool is_text(std::string_view bytes) {
  return std::ranges::all_of(
      bytes, [](char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\r' || c == '\n'; });
}

/// A text without the byte order mark that some programs begin it with.
std::string_view without_mark(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return text;
}

bool is_separator(char c) { return c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r'; }

/// Appends the numbers of a line to `values`; false if a field is not a number.
bool read_numbers(std::string_view text, std::vector<double>& values) {
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    while (at != end && is_separator(*at)) ++at;
    if (at == end) return true;
    if (*at == '+') ++at;
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error == std::errc::result_out_of_range) {
      value = HUGE_VAL;
    } else if (error != std::errc()) {
      return false;
    }
    if (next != end && !is_separator(*next)) return false;
    values.push_back(value);
    at = next;
  }
}

/// Sends frames at their times; a reader that falls behind gets the late ones at once.
class ReplaySource final : public LiveSource {
 public:
  ReplaySource(RowMajorMatrix voltages, FrameColumns channels, int repeat,
               std::optional<double> rate)
      : voltages_(std::move(voltages)), channels_(channels), repeat_(repeat), rate_(rate) {}

  bool can_wait() const override { return true; }

  std::string run(FrameSink& sink, Stop& stop) override {
    const SteadyClock::time_point start = SteadyClock::now();
    const auto total =
        static_cast<std::uint64_t>(voltages_.rows()) * static_cast<std::uint64_t>(repeat_);
    for (std::uint64_t number = 0; number < total; ++number) {
      const double due_s = rate_ ? static_cast<double>(number) / *rate_ : 0;
      const auto due = start + std::chrono::duration_cast<SteadyClock::duration>(
                                   std::chrono::duration<double>(due_s));
      do {
        if (stop.wait(-1, due - SteadyClock::now()) == Stop::Event::stopped) return "";
      } while (SteadyClock::now() < due);
      const auto row = static_cast<Eigen::Index>(number) % voltages_.rows();
      offer_frame({voltages_.row(row).data(), static_cast<std::size_t>(voltages_.cols())},
                  channels_, sink);
    }
    return "the file ended";
  }

 private:
  RowMajorMatrix voltages_;
  FrameColumns channels_;
  int repeat_;
  std::optional<double> rate_;
};

}  // namespace

const char* name_of(Damage damage) {
  constexpr const char* names[] = {"wrong length", "not numbers", "not voltages"};
  return names[static_cast<std::size_t>(damage)];
}

std::optional<FrameFormat> frame_format_named(std::string_view name) {
  if (name == "detect") return FrameFormat::detect;
  if (name == "binary") return FrameFormat::binary;
  if (name == "csv") return FrameFormat::csv;
  return std::nullopt;
}

void offer_frame(std::span<const double> voltages, FrameColumns channels, FrameSink& sink) {
  if (std::ssize(voltages) != channels.count) {
    sink.damaged(Damage::length);
  } else if (!std::ranges::all_of(voltages,
                                  [&](double v) { return std::abs(v) <= channels.most; })) {
    sink.damaged(Damage::value);
  } else {
    sink.frame(voltages);
  }
}

FrameParser::FrameParser(FrameColumns channels, FrameFormat format)
    : channels_(channels), format_(format) {}

void FrameParser::feed(std::string_view bytes, FrameSink& sink) {
  buffer_.append(bytes);
  if (format_ == FrameFormat::detect) {
    if (buffer_.size() < bytes_to_detect) return;
    format_ = is_text(without_mark(buffer_).substr(0, bytes_to_detect)) ? FrameFormat::csv
                                                                        : FrameFormat::binary;
  }
  if (format_ == FrameFormat::binary) {
    feed_binary(sink);
  } else {
    feed_lines(sink);
  }
}

void FrameParser::feed_binary(FrameSink& sink) {
  const std::size_t size = sizeof(double) * static_cast<std::size_t>(channels_.count);
  std::size_t at = 0;
  for (; at + size <= buffer_.size(); at += size) {
    binary(std::string_view(buffer_).substr(at, size), sink);
  }
  buffer_.erase(0, at);
}

void FrameParser::feed_lines(FrameSink& sink) {
  std::size_t at = 0;
  for (auto end = buffer_.find('\n'); end != std::string::npos; end = buffer_.find('\n', at)) {
    if (overlong_) {
      overlong_ = false;
    } else {
      line(std::string_view(buffer_).substr(at, end - at), sink);
    }
    at = end + 1;
  }
  buffer_.erase(0, at);
  if (buffer_.size() <= most_line_bytes_per_channel * static_cast<std::size_t>(channels_.count))
    return;
  buffer_.clear();
  if (!overlong_) sink.damaged(Damage::length);
  overlong_ = true;
}

void FrameParser::line(std::string_view text, FrameSink& sink) {
  const bool first = std::exchange(first_line_, false);
  if (first) text = without_mark(text);
  while (!text.empty() && is_separator(text.front())) text.remove_prefix(1);
  if (text.empty() || text[0] == '#' || (first && is_title_line(text))) return;
  values_.clear();
  if (!read_numbers(without_prefix(text, prefix_), values_)) return sink.damaged(Damage::text);
  const std::size_t rest = values_.empty() ? 0 : values_.size() - 1;
  if (std::cmp_equal(rest, channels_.count) && counts_values(values_[0], rest)) {
    values_.erase(values_.begin());
  }
  offer_frame(values_, channels_, sink);
}

void FrameParser::binary(std::string_view bytes, FrameSink& sink) {
  values_.resize(bytes.size() / sizeof(double));
  std::memcpy(values_.data(), bytes.data(), values_.size() * sizeof(double));
  offer_frame(values_, channels_, sink);
}

void FrameParser::pause(FrameSink& sink) {
  if (buffer_.empty() || format_ == FrameFormat::csv) return;
  buffer_.clear();
  sink.damaged(Damage::length);
}

void FrameParser::end(FrameSink& sink) {
  if (buffer_.empty()) return;
  const std::string rest = std::exchange(buffer_, {});
  if (format_ == FrameFormat::csv || (format_ == FrameFormat::detect && is_text(rest))) {
    if (!overlong_) line(rest, sink);
  } else {
    sink.damaged(Damage::length);
  }
}

void FrameParser::datagram(std::string_view bytes, FrameSink& sink) {
  const std::size_t size = sizeof(double) * static_cast<std::size_t>(channels_.count);
  if (format_ != FrameFormat::csv && bytes.size() == size && !is_text(bytes)) {
    binary(bytes, sink);
  } else if (format_ != FrameFormat::binary && !bytes.empty() && is_text(bytes)) {
    while (!bytes.empty() && bytes.back() == '\n') bytes.remove_suffix(1);
    line(bytes, sink);
  } else {
    sink.damaged(format_ == FrameFormat::csv ? Damage::text : Damage::length);
  }
}

std::unique_ptr<LiveSource> replay_of(RowMajorMatrix voltages, FrameColumns channels, int repeat,
                                      std::optional<double> rate) {
  return std::make_unique<ReplaySource>(std::move(voltages), channels, repeat, rate);
}

}  // namespace ertbench
