#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/arrays.h"

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

class Stop;

/// Where frames come from.
class LiveSource {
 public:
  virtual ~LiveSource() = default;
  /// Reads until there is no more or `stop` says so, and returns what ended it, for people; an
  /// empty text where it was `stop`. Throws InputError where the input broke off.
  virtual std::string run(FrameSink& sink, Stop& stop) = 0;
  /// Frames that the operating system threw away before they were read, where it says so.
  virtual std::uint64_t lost_before() const { return 0; }
  /// Whether a reader may let the sender wait.
  virtual bool can_wait() const { return false; }
};

/// What `--input` names: "-", "udp://HOST:PORT", "serial:DEVICE[@BAUD]", "replay:FILE.h5[@RATE]".
struct InputPlace {
  enum class Kind { standard_input, udp, serial, replay };
  Kind kind = Kind::standard_input;
  std::string name;            ///< host, device or file
  int port = 0;                ///< of UDP
  int baud = 115200;           ///< of a serial line
  std::optional<double> rate;  ///< frames/s of a replay; nothing: as fast as they are taken
};

/// Throws InputError naming the forms that there are.
InputPlace input_place(const std::string& text);

/// "HOST:PORT", as UDP and HTTP have it, "[::1]:9000" too. Throws InputError beginning with
/// `option`.
std::pair<std::string, int> host_and_port(const std::string& text, const std::string& option);

/// A file of frames in memory.
struct ReplayFrames {
  RowMajorMatrix voltages;  ///< [frames, channels] V; may hold values that are not finite
  int repeat = 1;           ///< how often they come
};

// All throw InputError where the place cannot be used.
std::unique_ptr<LiveSource> open_standard_input(int channels, FrameFormat format);
std::unique_ptr<LiveSource> open_serial(const InputPlace& place, int channels, FrameFormat format);
std::unique_ptr<LiveSource> open_udp(const InputPlace& place, int channels, FrameFormat format);
std::unique_ptr<LiveSource> replay_of(ReplayFrames frames, std::optional<double> rate);

}  // namespace ertbench
