#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// What makes a frame one that cannot be used.
enum class Damage {
  length,  ///< more or fewer values than the sensor has channels
  text,    ///< of a CSV line: what is no number
  value,   ///< not a number, endless, or no voltage that a sensor has (beyond 1 kV)
};
inline constexpr std::array all_damages = {Damage::length, Damage::text, Damage::value};
const char* name_of(Damage damage);

/// Takes what arrives.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// `voltages` [channels] V, all usable; valid during the call.
  virtual void frame(std::span<const double> voltages) = 0;
  virtual void damaged(Damage damage) = 0;
};

/// How frames stand in bytes: little-endian doubles without anything between them, or a line of
/// numbers each, separated by commas, semicolons or blanks.
enum class FrameFormat { detect, binary, csv };

/// Hands a frame on where its values can be used, else says that it is damaged.
void offer_frame(std::span<const double> voltages, int channels, FrameSink& sink);

/// Finds frames in a stream of bytes that may be cut anywhere. Not thread-safe.
///
/// Lines find their beginning again after any damage. Binary frames have nothing to find it by
/// but a pause of the sender, see `pause`. Lines that are empty or begin with '#' are passed over,
/// as is a first line of column titles.
class FrameParser {
 public:
  FrameParser(int channels, FrameFormat format);

  void feed(std::string_view bytes, FrameSink& sink);
  /// The sender has paused: what has begun and did not go on is no frame.
  void pause(FrameSink& sink);
  /// There is no more: a last line needs no end.
  void end(FrameSink& sink);

  /// A message that is one frame by itself.
  void datagram(std::string_view bytes, FrameSink& sink);

 private:
  void feed_binary(FrameSink& sink);
  void feed_lines(FrameSink& sink);
  void line(std::string_view text, FrameSink& sink);
  void binary(std::string_view bytes, FrameSink& sink);

  int channels_;
  FrameFormat format_;
  std::string buffer_;          ///< what is not yet a frame
  std::vector<double> values_;  ///< of the frame in hand
  bool first_line_ = true;
  bool overlong_ = false;  ///< within a line that is too long to be kept
};

/// "detect", "binary" and "csv".
std::optional<FrameFormat> frame_format_named(std::string_view name);

}  // namespace ertbench
