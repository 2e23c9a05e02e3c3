#include <chrono>
#include <utility>

#include "bench/live/live_source.h"
#include "bench/live/stop.h"
#include "core/seconds.h"

namespace ertbench {
namespace {

/// Frames from memory, each at its time: a reader that falls behind gets the late ones at once.
class ReplaySource final : public LiveSource {
 public:
  ReplaySource(ReplayFrames frames, std::optional<double> rate)
      : frames_(std::move(frames)), rate_(rate) {}

  bool can_wait() const override { return true; }

  std::string run(FrameSink& sink, Stop& stop) override {
    const SteadyClock::time_point start = SteadyClock::now();
    const auto channels = static_cast<std::size_t>(frames_.voltages.cols());
    for (std::uint64_t number = 0; number < total(); ++number) {
      const double due_s = rate_ ? static_cast<double>(number) / *rate_ : 0;
      const auto due = start + std::chrono::duration_cast<SteadyClock::duration>(
                                   std::chrono::duration<double>(due_s));
      do {
        if (stop.wait(-1, due - SteadyClock::now()) == Stop::Event::stopped) return "";
      } while (SteadyClock::now() < due);
      const auto row = static_cast<Eigen::Index>(number) % frames_.voltages.rows();
      offer_frame({frames_.voltages.row(row).data(), channels}, static_cast<int>(channels), sink);
    }
    return "the file ended";
  }

 private:
  std::uint64_t total() const {
    return static_cast<std::uint64_t>(frames_.voltages.rows()) *
           static_cast<std::uint64_t>(frames_.repeat);
  }

  ReplayFrames frames_;
  std::optional<double> rate_;
};

}  // namespace

std::unique_ptr<LiveSource> replay_of(ReplayFrames frames, std::optional<double> rate) {
  return std::make_unique<ReplaySource>(std::move(frames), rate);
}

}  // namespace ertbench
