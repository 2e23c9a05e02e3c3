// The page of a stream: as clients of every kind get it, and in a real browser.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <thread>

#include "live/live_server.h"
#include "tests/bench/browser.h"
#include "tests/bench/live_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// A stream that shows itself for as long as the test takes.
class ShownStream {
 public:
  explicit ShownStream(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {
        "live",     "--solver", "gn.json", "--input",     "replay:frames.h5@100",
        "--repeat", "10000",    "--http",  "127.0.0.1:0", "--deadline",
        "1000",     "--queue",  "100"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    program_ = std::make_unique<RunningProgram>(folder_.path(), arguments);
    const json begin = program_->event("begin");
    if (begin.is_null()) throw std::runtime_error(program_->errors());
    address = begin.at("http").get<std::string>();
    const auto colon = address.rfind(':');
    port = std::stoi(address.substr(colon + 1));
    // Nobody takes the lines away otherwise, and a pipe that is full stops the program.
    drain_ = std::thread([this] {
      while (const auto line = program_->line()) {
        const json value = json::parse(*line);
        if (value.contains("frame")) answered = value.at("frame").get<int>();
        if (value.contains("frame")) dropped = value.at("dropped").get<int>();
      }
    });
  }
  ~ShownStream() {
    program_->signal(SIGTERM);
    drain_.join();
    EXPECT_EQ(program_->exit_code(), 0) << program_->errors();
  }
  ShownStream(const ShownStream&) = delete;
  ShownStream& operator=(const ShownStream&) = delete;

  httplib::Client client() const {
    httplib::Client out("127.0.0.1", port);
    out.set_read_timeout(30);
    return out;
  }
  const fs::path& folder() const { return folder_.path(); }

  std::string address;
  int port = 0;
  std::atomic<int> answered = -1;
  std::atomic<int> dropped = 0;

 private:
  LiveFolder folder_;
  std::unique_ptr<RunningProgram> program_;
  std::thread drain_;
};

/// So many server-sent events.
std::vector<json> events_of(httplib::Client client, std::size_t count) {
  std::string text;
  std::vector<json> out;
  client.Get("/events", [&](const char* data, std::size_t size) {
    text.append(data, size);
    for (auto end = text.find("\n\n"); end != std::string::npos; end = text.find("\n\n")) {
      EXPECT_TRUE(text.starts_with("data: "));
      out.push_back(json::parse(text.substr(6, end - 6)));
      text.erase(0, end + 2);
    }
    return out.size() < count;
  });
  return out;
}

TEST(LivePage, EventsAreStatesOfTheStream) {
  const ShownStream stream;
  const std::vector<json> states = events_of(stream.client(), 6);
  ASSERT_GE(states.size(), 6u);
  for (std::size_t i = 1; i < states.size(); ++i) {
    EXPECT_GT(states[i].at("time_s"), states[i - 1].at("time_s"));
    EXPECT_GE(states[i].at("counts").at("came"), states[i - 1].at("counts").at("came"));
  }
  const json& last = states.back();
  EXPECT_EQ(last.at("solver"), "one-step-gn");
  EXPECT_EQ(last.at("image").size(), 576u);
  EXPECT_EQ(last.at("electrodes").size(), 16u);
  EXPECT_EQ(last.at("size_mm"), json({200.0, 200.0}));
  EXPECT_EQ(last.at("deadline_us"), 1e6);
  EXPECT_EQ(last.at("answer").at("status"), "ok");
  std::uint64_t counted = 0;
  for (const std::uint64_t one : last.at("histogram").at("counts")) counted += one;
  EXPECT_EQ(counted, last.at("counts").at("answered").get<std::uint64_t>());
  EXPECT_FALSE(last.at("finished"));
}

TEST(LivePage, NothingCanBeWrittenAndNothingComesFromElsewhere) {
  const ShownStream stream;
  httplib::Client client = stream.client();
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  for (const char* foreign : {"http://", "https://", "src=\"", "@import", "url("}) {
    EXPECT_EQ(page->body.find(foreign), std::string::npos) << foreign;
  }
  EXPECT_TRUE(page->get_header_value("Content-Security-Policy").starts_with("default-src 'none'"));
  EXPECT_EQ(client.Get("/state")->status, 200);
  EXPECT_EQ(client.Get("/nothing")->status, 404);
  EXPECT_EQ(client.Get("/../e.json")->status, 404);
  for (const auto& answer : {client.Post("/state", "x", "text/plain"), client.Delete("/state"),
                             client.Put("/", "x", "text/plain")}) {
    ASSERT_TRUE(answer);
    EXPECT_TRUE(answer->status == 405 || answer->status == 413) << answer->status;
  }
  // A page from elsewhere whose name leads to this machine.
  const auto named = client.Get("/state", {{"Host", "127.evil.example:8080"}});
  ASSERT_TRUE(named);
  EXPECT_EQ(named->status, 403);
  const auto rebound = client.Get("/state", {{"Host", "evil.example"}});
  ASSERT_TRUE(rebound);
  EXPECT_EQ(rebound->status, 403);
  const auto disguised = client.Get("/state", {{"Host", "127.0.0.1:80@evil.example"}});
  ASSERT_TRUE(disguised);
  EXPECT_EQ(disguised->status, 403);
  const auto twice = client.Get("/state", {{"Host", "127.0.0.1"}, {"Host", "evil.example"}});
  ASSERT_TRUE(twice);
  EXPECT_EQ(twice->status, 400);
  const auto pieces = client.Get("/", {{"Range", "bytes=0-9,0-9,0-9"}});
  ASSERT_TRUE(pieces);
  EXPECT_EQ(pieces->status, 416);
}

TEST(LivePage, MoreClientsThanMayWatchAreToldSo) {
  const ShownStream stream({"--http-clients", "2"});
  std::atomic<bool> over = false;
  std::atomic<int> watching = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 2; ++i) {
    clients.emplace_back([&] {
      bool first = true;
      stream.client().Get("/events", [&](const char*, std::size_t) {
        if (std::exchange(first, false)) ++watching;
        return !over;
      });
    });
  }
  while (watching < 2) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const auto refused = stream.client().Get("/events");
  const auto page = stream.client().Get("/");
  over = true;
  for (std::thread& client : clients) client.join();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
}

/// A connection that has asked for nothing yet, with as small a window as there is.
int connection_to(int port) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int small = 1024;
  ::setsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ::connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address);
  return descriptor;
}

/// A client that asks for events and never reads one.
int deaf_client(int port) {
  const int descriptor = connection_to(port);
  const std::string request = "GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  EXPECT_EQ(::send(descriptor, request.data(), request.size(), 0), std::ssize(request));
  return descriptor;
}

TEST(LivePage, AClientThatNeverReadsKeepsNobodyWaiting) {
  const ShownStream stream({"--http-clients", "3"});
  const int deaf = deaf_client(stream.port);
  const int silent = connection_to(stream.port);
  // Far more than buffers hold: 600 frames are 6 s, with 25 states of some kilobytes a second.
  const int before = stream.answered;
  const auto begin = std::chrono::steady_clock::now();
  while (stream.answered < before + 600) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ASSERT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(120));
  }
  EXPECT_GE(events_of(stream.client(), 3).size(), 3u);
  ::close(deaf);
  ::close(silent);
}

TEST(LivePage, ARequestWithoutEndIsEnded) {
  const ShownStream stream;
  std::vector<int> idle(100);
  for (int& one : idle) one = connection_to(stream.port);
  const int slow = connection_to(stream.port);
  const std::string request = "GET / HTTP/1.1\r\nX: " + std::string(1000, 'x');
  bool ended = false;
  for (std::size_t i = 0; i < request.size() && !ended; ++i) {
    char answer = 0;
    ended = ::send(slow, &request[i], 1, MSG_NOSIGNAL) != 1 ||
            ::recv(slow, &answer, 1, MSG_DONTWAIT) >= 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_TRUE(ended) << "a byte every now and then keeps its thread for ever";
  const auto state = stream.client().Get("/state");
  ASSERT_TRUE(state);
  EXPECT_EQ(state->status, 200);
  for (const int one : idle) ::close(one);
  ::close(slow);
}

// The browser's clock stands still while a page waits for the network, and the stream's does not:
// what the page looks like is seen when the stream has ended. One that lasts some seconds longer
// than a browser takes to start for the first time on a busy machine.
TEST(LivePage, ABrowserShowsWhatTheStreamSays) {
  const std::optional<fs::path> browser = find_browser();
  if (!browser) GTEST_SKIP() << "no /usr/bin/chromium; apt-get install chromium";
  const LiveFolder folder;
  RunningProgram program(
      folder.path(), {"live", "--solver", "gn.json", "--input", "replay:frames.h5@50", "--repeat",
                      "24", "--http", "127.0.0.1:0", "--deadline", "1000"});
  const json begin = program.event("begin");
  ASSERT_FALSE(begin.is_null()) << program.errors();
  std::vector<json> lines;
  std::thread drain([&] { lines = program.lines(); });
  const std::string command =
      "timeout 120 " + browser->string() +
      " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run"
      " --disable-background-networking --disable-component-update --disable-sync"
      " --disable-dev-shm-usage --enable-logging=stderr --virtual-time-budget=600000"
      " --user-data-dir=" +
      quoted((folder / "profile").string()) + " --dump-dom " + begin.at("http").get<std::string>() +
      " 2>" + quoted((folder / "browser.log").string()) + " </dev/null >" +
      quoted((folder / "dom.html").string());
  const int status = std::system(command.c_str());
  drain.join();
  const std::string log = read_text(folder / "browser.log");
  ASSERT_EQ(status, 0) << log;
  EXPECT_EQ(log.find(":CONSOLE"), std::string::npos) << log;
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  const std::string dom = read_text(folder / "dom.html");
  for (const char* part : {">one-step-gn<", ">the stream has ended<", "<tr><td>1</td>"}) {
    EXPECT_NE(dom.find(part), std::string::npos) << part << "\n" << dom;
  }
  // The frame that it shows is one of the last, with the contact that was found in it.
  const std::string mark = "data-frame=\"";
  const auto at = dom.find(mark);
  ASSERT_NE(at, std::string::npos) << dom;
  const int frame = std::stoi(dom.substr(at + mark.size()));
  const std::vector<json> answers = answers_of(lines);
  EXPECT_GT(frame, answers.back().at("frame").get<int>() - 20);
  const auto shown = std::find_if(answers.begin(), answers.end(),
                                  [&](const json& one) { return one.at("frame") == frame; });
  ASSERT_NE(shown, answers.end());
  char x[32];
  std::snprintf(x, sizeof x, "<td>%.1f</td>", shown->at("contacts").at(0).at("x_mm").get<double>());
  EXPECT_NE(dom.find(x), std::string::npos) << x << "\n" << dom;
}

}  // namespace
}  // namespace ertbench
