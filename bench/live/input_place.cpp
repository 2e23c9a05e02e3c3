#include <charconv>
#include <tuple>

#include "bench/live/live_source.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// The number behind the last '@', which is taken off `text`; nothing where none stands there.
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

}  // namespace

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
      if (*baud < 1 || *baud > 1e8)
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

}  // namespace ertbench
