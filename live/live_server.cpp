#include "live/live_server.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <string_view>
#include <thread>

#include "core/errors.h"
#include "core/seconds.h"
#include "core/text.h"
#include "live/live_state.h"

namespace ertbench {
namespace {

constexpr int write_patience_ms = 2000;
constexpr int request_patience_ms = 1000;  ///< for all of a request
constexpr int hurried_patience_ms = 20;    ///< while many others are late
/// Threads beside those of the watching clients; they serve the page and refuse further clients.
constexpr int further_threads = 64;
constexpr int many_late = 32;  ///< connections that have not asked yet

bool wait_for(int socket, short event, int patience_ms) {
  pollfd one{socket, event, 0};
  return ::poll(&one, 1, std::max(0, patience_ms)) > 0;
}

/// A connection whose whole request must come in time, however slowly its bytes come.
class BoundedStream final : public httplib::Stream {
 public:
  BoundedStream(socket_t socket, int patience_ms) : socket_(socket), patience_ms_(patience_ms) {}

  bool is_readable() const override { return wait_for(socket_, POLLIN, left_ms()); }
  bool is_writable() const override { return wait_for(socket_, POLLOUT, write_patience_ms); }
  ssize_t read(char* bytes, std::size_t size) override {
    return is_readable() ? ::recv(socket_, bytes, size, MSG_DONTWAIT) : -1;
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    return is_writable() ? ::send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT) : -1;
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }

 private:
  int left_ms() const { return patience_ms_ - static_cast<int>(1000 * seconds_since(start_)); }

  socket_t socket_;
  int patience_ms_;
  SteadyClock::time_point start_ = SteadyClock::now();
};

/// Answers one request a connection. Where many connections are late with theirs, further ones must
/// be quick.
class BoundedServer final : public httplib::Server {
  bool process_and_close_socket(socket_t socket) override {
    const bool hurried = ++late_ > many_late;
    const bool asked =
        wait_for(socket, POLLIN, hurried ? hurried_patience_ms : request_patience_ms);
    BoundedStream stream(socket, hurried ? hurried_patience_ms : request_patience_ms);
    --late_;
    bool closed = false;
    const bool answered = asked && process_request(stream, true, closed, nullptr);
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return answered;
  }

  std::atomic<int> late_ = 0;
};

/// "127.0.0.1" of "127.0.0.1:8080", "::1" of "[::1]:8080"; nothing where what follows is no port.
std::string host_of(const std::string& header) {
  const bool bracketed = header.starts_with('[');
  const std::size_t end = std::min(header.find(bracketed ? ']' : ':'), header.size());
  std::string_view rest = std::string_view(header).substr(end);
  if (bracketed && rest.starts_with(']')) rest.remove_prefix(1);
  const bool port = rest.starts_with(':') && rest.size() > 1 &&
                    rest.find_first_not_of("0123456789", 1) == std::string_view::npos;
  if (!rest.empty() && !port) return {};
  return header.substr(bracketed ? 1 : 0, end - (bracketed ? 1 : 0));
}

/// The status by which a request is refused, or 0.
int refused(const httplib::Request& request, bool loopback_only) {
  if (request.get_header_value_count("Host") != 1) return 400;
  if (loopback_only && !is_loopback(host_of(request.get_header_value("Host")))) return 403;
  if (request.method != "GET" && request.method != "HEAD") return 405;
  // Many ranges of one page would be many times its size.
  return request.has_header("Range") ? 416 : 0;
}

}  // namespace

bool is_loopback(const std::string& host) {
  // A host name may begin with "127." and resolve to any machine, so only parsed addresses count.
  in_addr address{};
  const bool parsed = ::inet_pton(AF_INET, host.c_str(), &address) == 1;
  return host == "localhost" || host == "::1" || (parsed && ntohl(address.s_addr) >> 24 == 127);
}

struct LiveServer::Parts {
  BoundedServer server;
  LiveState& state;
  LiveServerOptions options;
  std::thread thread;

  Parts(const LiveServerOptions& its_options, LiveState& its_state)
      : state(its_state), options(its_options) {}

  void add_pages();
  void watch(httplib::Response& response);
};

void LiveServer::Parts::watch(httplib::Response& response) {
  if (++state.watchers > options.clients) {
    --state.watchers;
    response.status = 503;
    response.set_content("as many clients are served as may be (--http-clients)\n", "text/plain");
    return;
  }
  // The last copy frees the client's place.
  const std::shared_ptr<std::atomic<int>> place(&state.watchers, [](auto* count) { --*count; });
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, place, version = std::uint64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
        const bool last = state.finished();
        if (!last) version = state.wait_for_newer(version);
        std::string event = "data: ";
        event.append(state.json()).append("\n\n");
        if (!sink.write(event.data(), event.size())) return false;
        if (last) sink.done();
        return true;
      });
}

void LiveServer::Parts::add_pages() {
  const int threads = options.clients + further_threads;
  server.new_task_queue = [threads] {
    return new httplib::ThreadPool(static_cast<std::size_t>(threads));
  };
  server.set_payload_max_length(0);
  server.set_tcp_nodelay(true);
  server.set_default_headers(
      {{"Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
       {"X-Content-Type-Options", "nosniff"},
       {"Referrer-Policy", "no-referrer"}});
  server.set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        const int status = refused(request, is_loopback(options.host));
        if (status == 0) return httplib::Server::HandlerResponse::Unhandled;
        response.status = status;
        if (status == 403) {
          response.set_content("ask for this machine by its address\n", "text/plain");
        }
        if (status == 405) response.set_header("Allow", "GET, HEAD");
        return httplib::Server::HandlerResponse::Handled;
      });
  server.Get("/", [](const httplib::Request&, httplib::Response& response) {
    response.set_content(live_page(), "text/html; charset=utf-8");
  });
  server.Get("/state", [this](const httplib::Request&, httplib::Response& response) {
    response.set_header("Cache-Control", "no-store");
    response.set_content(state.json() + "\n", "application/json");
  });
  server.Get("/events",
             [this](const httplib::Request&, httplib::Response& response) { watch(response); });
}

LiveServer::LiveServer(const LiveServerOptions& options, LiveState& state)
    : parts_(std::make_unique<Parts>(options, state)) {
  parts_->add_pages();
  LiveServerOptions& own = parts_->options;
  if (own.port == 0) {
    own.port = parts_->server.bind_to_any_port(own.host);
  } else if (!parts_->server.bind_to_port(own.host, own.port)) {
    own.port = -1;
  }
  if (own.port <= 0) {
    throw InputError("--http: " + printable(options.host) + ":" + std::to_string(options.port) +
                     " cannot be listened at; name an address of this machine and a port that is "
                     "free, or port 0 for any");
  }
  parts_->thread = std::thread([this] { parts_->server.listen_after_bind(); });
}

LiveServer::~LiveServer() {
  parts_->state.finish();
  while (!parts_->server.is_running()) std::this_thread::yield();
  parts_->server.stop();
  parts_->thread.join();
}

int LiveServer::port() const { return parts_->options.port; }

std::string LiveServer::address() const {
  const std::string& host = parts_->options.host;
  const bool ip6 = host.find(':') != std::string::npos;
  return "http://" + (ip6 ? "[" + host + "]" : host) + ":" + std::to_string(port()) + "/";
}

}  // namespace ertbench
