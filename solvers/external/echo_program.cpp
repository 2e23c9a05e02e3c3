#include "solvers/external/echo_program.h"

#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "solvers/external/frame_exchange.h"

namespace ertbench {
namespace {

bool read_whole(char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t some = ::read(STDIN_FILENO, bytes, count);
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) return false;
    bytes += some;
    count -= static_cast<std::size_t>(some);
  }
  return true;
}

bool write_whole(const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t some = ::write(STDOUT_FILENO, bytes, count);
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) return false;
    bytes += some;
    count -= static_cast<std::size_t>(some);
  }
  return true;
}

/// The life of the program that answers.
void answer_frames(std::size_t channels, std::size_t pixels) {
  std::vector<double> frames;
  std::vector<char> images;
  std::uint64_t count = 0;
  while (read_whole(reinterpret_cast<char*>(&count), sizeof count)) {
    frames.resize(count * channels);
    images.resize(count * (pixels * sizeof(double) + 1));
    if (!read_whole(reinterpret_cast<char*>(frames.data()), frames.size() * sizeof(double))) return;
    if (!write_whole(images.data(), images.size())) return;
  }
}

class EchoSolver final : public Solver {
 public:
  explicit EchoSolver(const Sensor& sensor)
      : program_(
            "echo",
            [channels = static_cast<std::size_t>(sensor.channels()),
             pixels = static_cast<std::size_t>(sensor.pixels())] {
              answer_frames(channels, pixels);
              ::_exit(
                  0);  // a copy of this process: what else it is to do at its end is not its own
            },
            0),
        exchange_(program_, limit_s) {}

  nlohmann::json parameters() const override { return nlohmann::json::object(); }
  void fit(const FitInput&) override {}
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override {
    exchange_.reconstruct(changes, images, reports);
  }
  void save(const std::filesystem::path&) const override {
    throw std::logic_error("the echo of frames is not kept");
  }
  void load(const std::filesystem::path&, const Sensor&) override {
    throw std::logic_error("the echo of frames is not kept");
  }

 private:
  static constexpr double limit_s = 10;

  Program program_;
  mutable FrameExchange exchange_;
};

}  // namespace

std::unique_ptr<Solver> echo_solver(const Sensor& sensor) {
  return std::make_unique<EchoSolver>(sensor);
}

}  // namespace ertbench
