// Solvers that do what a plugin must not do, where and when they are told.

#include <sys/types.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/json.h"
#include "solvers/registry/registry.h"

namespace {

using namespace ertbench;

void sleep_s(int seconds) { std::this_thread::sleep_for(std::chrono::seconds(seconds)); }

/// A process of its own, in a session of its own where asked, whose number it leaves in a file.
void leave_process(const std::string& file, bool own_session) {
  if (::fork() != 0) {
    for (std::string text; text.empty(); std::getline(std::ifstream(file), text)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return;
  }
  if (own_session) ::setsid();
  if (::fork() != 0) ::_exit(0);  // its parent is gone at once
  std::ofstream(file) << ::getpid() << "\n";
  sleep_s(600);
  ::_exit(0);
}

void misbehave(const std::string& how) {
  if (how == "exit") std::exit(0);
  if (how == "hang") sleep_s(3600);
  if (how == "segv") {
    std::signal(SIGSEGV, SIG_DFL);  // which a sanitizer has made an exit
    std::raise(SIGSEGV);
  }
  if (how == "throw") throw std::runtime_error("\x1b[31mthe matrix\xff is on fire");
  if (how == "throw-number") throw 42;
  if (how == "memory") {
    std::vector<std::vector<char>> held;
    for (int i = 0; i < 300; ++i) held.emplace_back(std::size_t{100} << 20, 1);  // 30 GB
    sleep_s(held.size() > 1 ? 3600 : 0);
  }
  if (how == "stderr") {
    const std::string line(1000, 'x');
    for (;;) std::fprintf(stderr, "%s\n", line.c_str());
  }
}

class Hostile final : public Solver {
 public:
  explicit Hostile(JsonObject object)
      : how_(object.text("how")),
        when_(object.choice_or("when", "construct", {"construct", "fit", "end"})),
        file_(object.text_or("file", "")) {
    object.finish();
    if (when_ == "construct") misbehave(how_);
  }
  ~Hostile() override {
    if (when_ == "end") misbehave(how_);
  }

  nlohmann::json parameters() const override { return {{"how", how_}}; }
  void fit(const FitInput&) override {
    if (!file_.empty()) leave_process(file_, how_ == "setsid");
    if (when_ == "fit") misbehave(how_);
  }
  void reconstruct(FramesView, ImagesView images, std::span<FrameReport>) const override {
    images.setZero();
  }
  void save(const std::filesystem::path& file) const override { std::ofstream(file) << how_; }
  void load(const std::filesystem::path&, const Sensor&) override {}

 private:
  std::string how_;
  std::string when_;
  std::string file_;
};

}  // namespace

ERTBENCH_SOLVER_PLUGIN
extern "C" void ertbench_register_solvers(SolverRegistry& registry) {
  if (const char* how = std::getenv("HOSTILE_LOAD")) misbehave(how);
  registry.add("hostile",
               {"\x1b[2J does \xff what it must not",
                {{"how", "exit, hang, segv, throw, throw-number, memory, stderr, child, setsid"},
                 {"when", "construct, fit or end"},
                 {"file", "for the number of a process that it leaves behind"}},
                make_from_json<Hostile>});
}
