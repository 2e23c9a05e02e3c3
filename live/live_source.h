#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// Why a frame cannot be used.
enum class Damage {
  length,  ///< more or fewer values than the sensor has channels
  text,    ///< a CSV field is not a number
  value,   ///< NaN, infinite, or beyond 1 kV
};
inline constexpr std::array all_damages = {Damage::length, Damage::text, Damage::value};
const char* name_of(Damage damage);

/// What a frame of the sender looks like.
struct FrameColumns {
  // NOLINTNEXTLINE(google-explicit-constructor): a number of columns in V is the usual case.
  FrameColumns(int number, double most_value = 1000) : count(number), most(most_value) {}
  int count;
  double most;  ///< largest absolute value: 1 kV in the sender's unit
};

class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// `voltages` [columns] as sent, all usable; valid during the call.
  virtual void frame(std::span<const double> voltages) = 0;
  virtual void damaged(Damage damage) = 0;
};

/// Encoding of frames: packed little-endian doubles, or lines of numbers separated by commas,
/// semicolons or blanks.
enum class FrameFormat { detect, binary, csv };

/// Hands a usable frame to `sink`, or reports its damage.
void offer_frame(std::span<const double> voltages, FrameColumns channels, FrameSink& sink);

/// Finds frames in a stream of bytes that may be cut anywhere. Not thread-safe.
///
/// Lines resynchronise after any damage; binary frames only after a pause of the sender, see
/// `pause`. Empty lines, those that begin with '#' and a first line of column titles are skipped.
class FrameParser {
 public:
  FrameParser(FrameColumns channels, FrameFormat format);

  void feed(std::string_view bytes, FrameSink& sink);
  /// Call when the sender has paused: an incomplete binary frame is damaged.
  void pause(FrameSink& sink);
  /// Call at the end of the stream: the last line needs no newline.
  void end(FrameSink& sink);

  /// Parses a message that is exactly one frame.
  void datagram(std::string_view bytes, FrameSink& sink);

 private:
  void feed_binary(FrameSink& sink);
  void feed_lines(FrameSink& sink);
  void line(std::string_view text, FrameSink& sink);
  void binary(std::string_view bytes, FrameSink& sink);

  FrameColumns channels_;
  FrameFormat format_;
  std::string buffer_;  ///< bytes of the next frame
  std::vector<double> values_;
  bool first_line_ = true;
  std::string prefix_;     ///< words before the numbers of the last line
  bool overlong_ = false;  ///< inside a line that was too long to keep
};

/// Names are "detect", "binary" and "csv".
std::optional<FrameFormat> frame_format_named(std::string_view name);

class Stop;

/// An input of frames.
class LiveSource {
 public:
  virtual ~LiveSource() = default;
  /// Reads until there is no more or `stop` says so, and returns what ended it, for people; an
  /// empty text where it was `stop`. Throws InputError where the input broke off.
  virtual std::string run(FrameSink& sink, Stop& stop) = 0;
  /// Number of frames the operating system discarded before they were read, if it counts them.
  virtual std::uint64_t lost_before() const { return 0; }
  /// True if the reader may let the sender wait.
  virtual bool can_wait() const { return false; }
};

/// A parsed `--input`: "-", "udp://HOST:PORT", "serial:DEVICE[@BAUD]" or "replay:FILE.h5[@RATE]".
struct InputPlace {
  enum class Kind { standard_input, udp, serial, replay };
  Kind kind = Kind::standard_input;
  std::string name;            ///< host, device or file
  int port = 0;                ///< of UDP
  int baud = 115200;           ///< of a serial line
  std::optional<double> rate;  ///< frames/s of a replay; nothing: as fast as they are taken
};

/// Throws InputError naming the accepted forms.
InputPlace input_place(const std::string& text);

/// Parses "HOST:PORT", also "[::1]:9000". Throws InputError that begins with `option`.
std::pair<std::string, int> host_and_port(const std::string& text, const std::string& option);

// All throw InputError if the place cannot be used.
std::unique_ptr<LiveSource> open_standard_input(FrameColumns channels, FrameFormat format);
std::unique_ptr<LiveSource> open_serial(const InputPlace& place, FrameColumns channels,
                                        FrameFormat format);
std::unique_ptr<LiveSource> open_udp(const InputPlace& place, FrameColumns channels,
                                     FrameFormat format);
/// `voltages` [frames, columns] may hold values that are not finite; sent `repeat` times.
std::unique_ptr<LiveSource> replay_of(RowMajorMatrix voltages, FrameColumns channels, int repeat,
                                      std::optional<double> rate);

/// Sends datagrams to one address and never waits: what nobody takes is lost.
class DatagramSender {
 public:
  /// `address`: "udp://HOST:PORT" of the option `--send`. Throws InputError.
  explicit DatagramSender(const std::string& address);
  DatagramSender(const DatagramSender&) = delete;
  DatagramSender& operator=(const DatagramSender&) = delete;
  ~DatagramSender();

  void send(const std::string& bytes) const;

 private:
  int descriptor_ = -1;
};

}  // namespace ertbench
