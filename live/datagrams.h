#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "forward/sheet/sensor.h"
#include "live/live_solver.h"

namespace ertbench {

/// The record of an answer of version 1, which `--send-format binary` sends as one datagram. All
/// numbers are little-endian.
///
///     offset  type     what
///     0       char[4]  "ERTC"
///     4       uint16   version, 1
///     6       uint16   number of contacts
///     8       uint64   number of the frame
///     16      float64  time of its arrival since the stream began, s
///     24      float32  latency from its arrival to the answer, s
///     28      uint8    status, 0: ok (FrameStatus)
///     29      uint8    reasons, bits (FrameReason, FrameFault)
///     30      uint16   0
///     32      uint64   dead electrodes, bit e for electrode e
///     40      contacts, the strongest first, six float32 each: x and y in mm from the sheet's
///             centre, strength in S/m mm2, peak in S/m, area in mm2, force in N or NaN
std::string binary_record(const LiveAnswer& answer, const Sensor& sensor, std::uint64_t frame,
                          double time_s, double latency_s);

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
