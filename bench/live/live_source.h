#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "bench/live/frame_parser.h"
#include "core/arrays.h"

namespace ertbench {

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
