#pragma once

#include <Eigen/Dense>
#include <memory>
#include <string>

// Debian built the library with these; whoever includes its header must define the same. It
// includes <resolv.h>, whose macro `_res` is a name in Eigen, which is therefore included first.
#define CPPHTTPLIB_OPENSSL_SUPPORT
#define CPPHTTPLIB_ZLIB_SUPPORT
#define CPPHTTPLIB_BROTLI_SUPPORT
#include <httplib.h>
#undef _res

namespace ertbench {

/// The text of live/page.html, which the build embeds. It listens to `/events`.
const std::string& live_page();

class LiveState;

struct LiveServerOptions {
  std::string host = "127.0.0.1";
  int port = 8080;  ///< 0: any that is free
  int clients = 4;  ///< served at a time
};

/// Shows a stream to browsers, read-only: `/` is a self-contained page, `/state` the newest state
/// as JSON, `/events` the states that follow as server-sent events.
///
/// Each client has its own thread and gets the newest state once it has taken the one before. A
/// client that does not read is cut off after two seconds; none keeps the solver waiting. Clients
/// beyond the limit get status 503. At a loopback address only requests whose Host header names
/// that address are answered, which stops DNS rebinding by foreign pages.
class LiveServer {
 public:
  /// Listens at once. `state` must outlive this. Throws InputError if the address cannot be bound.
  LiveServer(const LiveServerOptions& options, LiveState& state);
  ~LiveServer();

  int port() const;
  std::string address() const;  ///< "http://127.0.0.1:8080/"

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// True if only this machine can reach the address.
bool is_loopback(const std::string& host);

}  // namespace ertbench
