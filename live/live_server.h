#pragma once

#include <httplib.h>

#include <Eigen/Dense>
#include <memory>
#include <string>

// Eigen first: the library's header brings in <resolv.h>, whose macro `_res` is a name in Eigen.

// How Debian built the library: its header asks whoever includes it for the same.
#define CPPHTTPLIB_OPENSSL_SUPPORT
#define CPPHTTPLIB_ZLIB_SUPPORT
#define CPPHTTPLIB_BROTLI_SUPPORT
#undef _res

namespace ertbench {

/// The page that shows a stream: HTML with its style and its script in it, without anything from
/// elsewhere. It listens to `/events`.
const std::string& live_page();

class LiveState;

struct LiveServerOptions {
  std::string host = "127.0.0.1";
  int port = 8080;  ///< 0: any that is free
  int clients = 4;  ///< that are served at a time
};

/// Shows a stream to browsers: `/` is a page that needs nothing else, `/state` the newest state as
/// JSON, `/events` all that follow as server-sent events. There is nothing to be written or
/// changed.
///
/// Each client has a thread of its own and gets the newest state when it has taken the one before;
/// one that does not read is cut off after two seconds, and none keeps the solver waiting. More
/// clients than there may be are told so (503). At a loopback address only requests that name it as
/// their host are answered, so that no page from elsewhere gets at the data by a name of its own.
class LiveServer {
 public:
  /// Listens at once. `state` must outlive this. Throws InputError where the address cannot be had.
  LiveServer(const LiveServerOptions& options, LiveState& state);
  ~LiveServer();

  int port() const;
  std::string address() const;  ///< "http://127.0.0.1:8080/"

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Whether only this machine can reach the address.
bool is_loopback(const std::string& host);

}  // namespace ertbench
