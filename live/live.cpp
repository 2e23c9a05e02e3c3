#include "live/live.h"

#include <spdlog/spdlog.h>

#include <csignal>
#include <exception>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "core/errors.h"
#include "core/json.h"
#include "frames/own_frames.h"
#include "live/live_record.h"
#include "live/live_server.h"
#include "solvers/registry/named_solver.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds look_around{100};
constexpr double damage_said_every_s = 1;
constexpr int most_judged = 1000;  ///< frames without contact

/// The reader thread's side: numbers frames, stamps them and puts them into the mailbox.
class StreamReader final : public FrameSink {
 public:
  StreamReader(const ChannelMap& map, Mailbox& mailbox, LiveRecord* record,
               SteadyClock::time_point start)
      : map_(map), mailbox_(mailbox), record_(record), start_(start) {}

  void frame(std::span<const double> voltages) override {
    const SteadyClock::time_point arrived = SteadyClock::now();
    ArrivedFrame frame{
        came_++, arrived,
        map_.apply(Eigen::Map<const Eigen::RowVectorXd>(voltages.data(), std::ssize(voltages)))};
    if (record_) record_->came(frame, std::chrono::duration<double>(arrived - start_).count());
    mailbox_.put(std::move(frame));
  }
  void damaged(Damage damage) override { ++damaged_[static_cast<std::size_t>(damage)]; }

  /// Called by the other thread.
  void count(LiveCounts& counts) const {
    counts.came = came_;
    for (std::size_t d = 0; d < damaged_.size(); ++d) counts.damaged[d] = damaged_[d];
  }

 private:
  const ChannelMap& map_;
  Mailbox& mailbox_;
  LiveRecord* record_;
  SteadyClock::time_point start_;
  std::atomic<std::uint64_t> came_ = 0;
  std::array<std::atomic<std::uint64_t>, all_damages.size()> damaged_{};
};

/// The solver thread's side of a stream.
class Stream {
 public:
  Stream(const LiveOptions& options, LiveSetup& setup, LiveState& state, Stop& stop)
      : options_(options),
        stop_(stop),
        solver_(*setup.solver),
        source_(*setup.source),
        fit_(setup.fit),
        map_(setup.map),
        state_(state),
        mailbox_(options.places, options.lossless, options.background),
        output_(stop) {
    if (!options.send.empty()) sender_.emplace(options.send);
    if (!options.record.empty()) record_.emplace(options.record, setup.files, solver_.sensor());
  }

  LiveSummary run(const std::string& parameters) {
    reader_.emplace(map_, mailbox_, record_ ? &*record_ : nullptr, start_);
    std::exception_ptr input_failure;
    std::exception_ptr failure;
    std::string why;
    std::thread thread([&] {
      try {
        why = source_.run(*reader_, stop_);
      } catch (...) {
        input_failure = std::current_exception();
      }
      mailbox_.close(stop_.stopped());
    });
    bool ended = false;
    try {
      ended = answer_all();
    } catch (...) {
      failure = std::current_exception();
    }
    const bool told = stop_.stopped();
    if (!ended) stop_.stop();  // otherwise a slow reader gets all the time it needs
    mailbox_.close(true);
    thread.join();
    if (!failure) failure = input_failure;
    if (ended && !failure && !told && background_frames_ < options_.background) {
      failure =
          std::make_exception_ptr(InputError("--background: the input ended after " +
                                             std::to_string(background_frames_) + " of them"));
    }
    count();
    summary_.why = output_.error() != 0       ? "standard output cannot be written"
                   : !output_.open() && !told ? "nobody reads the output any more"
                   : failure                  ? "the input broke off, or the solver failed"
                   : why.empty()              ? "it was told to end"
                                              : why;
    try {
      finish_record(parameters);
    } catch (const std::exception& error) {
      if (failure) {
        spdlog::error("{}", error.what());  // the first failure ends the program
      } else {
        failure = std::current_exception();
      }
    }
    summary_.seconds = seconds_since(start_);
    say_end();
    if (!failure && output_.error() != 0) {
      throw InputError("standard output cannot be written: " +
                       std::generic_category().message(output_.error()));
    }
    if (failure) std::rethrow_exception(failure);
    return summary_;
  }

  void say(const json& event) { output_.line(event); }

 private:
  double now_s() const { return seconds_since(start_); }

  void count() {
    reader_->count(summary_.counts);
    summary_.counts.dropped = mailbox_.dropped() + source_.lost_before();
  }

  /// Returns true if the input ended and every frame was answered.
  bool answer_all() {
    ArrivedFrame frame;
    while (output_.open()) {
      const Mailbox::Taken taken = mailbox_.take(frame, look_around);
      if (taken == Mailbox::Taken::closed) return true;
      count();
      if (taken == Mailbox::Taken::nothing) {
        listen();
        state_.update(summary_.counts, now_s());
      } else {
        heard(frame);
        solver_.reference().size() == 0 ? add_background(frame) : answer(frame);
      }
      say_damage();
    }
    return false;
  }

  void add_background(const ArrivedFrame& frame) {
    if (background_sum_.size() == 0) {
      background_sum_.setZero(frame.voltages.size());
      background_.resize(std::min(options_.background, most_judged), frame.voltages.size());
    }
    if (background_frames_ < background_.rows()) {
      background_.row(background_frames_) = frame.voltages;
    }
    background_sum_ += frame.voltages;
    if (++background_frames_ < options_.background) return;
    if (!options_.force) require_quiet(solver_.sensor(), background_, "--background");
    take_reference(solver_, background_sum_ / background_frames_, options_);
    if (fit_) {
      solver_.use(fit_(solver_.expected().row(0).transpose(), relative_noise(background_)));
    }
    say({{"event", "background"}, {"frames", background_frames_}, {"time_s", now_s()}});
  }

  void answer(const ArrivedFrame& frame) {
    const double arrived_s = std::chrono::duration<double>(frame.arrived - start_).count();
    // The tracker needs strictly increasing times; a clock's resolution may give two alike.
    last_time_s_ = std::max(arrived_s, last_time_s_ + 1e-9);
    const LiveAnswer& answer = solver_.answer(frame.voltages, last_time_s_);
    const double latency_s = seconds_since(frame.arrived);
    LiveCounts& counts = summary_.counts;
    ++counts.answered;
    counts.late += options_.deadline_s > 0 && latency_s > options_.deadline_s;
    summary_.latency.add(latency_s);
    if (record_) record_->answered(frame.number, latency_s, answer);
    json line = answer_json(answer, solver_.sensor());
    line.update({{"frame", frame.number},
                 {"time_s", arrived_s},
                 {"latency_us", 1e6 * latency_s},
                 {"solver_us", 1e6 * answer.solver_s},
                 {"dropped", counts.dropped}});
    if (options_.images) {
      line["image"] =
          std::vector<double>(answer.image.data(), answer.image.data() + answer.image.size());
    }
    output_.line(line);
    if (sender_) {
      sender_->send(options_.send_binary ? binary_record(answer, solver_.sensor(), frame.number,
                                                         arrived_s, latency_s)
                                         : json_text(line) + "\n");
    }
    state_.update(counts, now_s(), frame, answer, latency_s);
  }

  void listen() {
    const double silent_s = now_s() - last_heard_s_;
    if (silent_s < options_.silence_s) return;
    state_.set_silence(silent_s);
    if (std::exchange(silent_, true)) return;
    spdlog::warn("no usable frame for {:.1f} s: is the sender alive?", silent_s);
    say({{"event", "silence"}, {"time_s", now_s()}, {"silent_s", silent_s}});
  }

  void heard(const ArrivedFrame& frame) {
    last_heard_s_ = std::chrono::duration<double>(frame.arrived - start_).count();
    if (!std::exchange(silent_, false)) return;
    state_.set_silence(0);
    say({{"event", "resumed"}, {"time_s", now_s()}});
  }

  void say_damage() {
    const std::uint64_t damaged = summary_.counts.all_damaged();
    if (damaged == damaged_said_ || now_s() < damage_said_s_ + damage_said_every_s) return;
    if (damaged_said_ == 0) spdlog::warn("damaged frames come; they are passed over");
    damaged_said_ = damaged;
    damage_said_s_ = now_s();
    say({{"event", "damaged"},
         {"time_s", now_s()},
         {"damaged", counts_json(summary_.counts).at("damaged")}});
  }

  void finish_record(const std::string& parameters) {
    if (!record_) return;
    if (!record_->finish(solver_.reference(), parameters)) {
      spdlog::warn("no frame came: {} is not written", options_.record);
    } else if (record_->not_kept() > 0) {
      spdlog::warn("{} rows were not kept in {}: the disk is too slow", record_->not_kept(),
                   options_.record);
    }
  }

  void say_end() {
    json end = counts_json(summary_.counts);
    end.update({{"event", "end"},
                {"why", summary_.why},
                {"seconds", summary_.seconds},
                {"latency_us", latency_json(summary_.latency)},
                {"histogram", histogram_json(summary_.latency)}});
    say(end);
  }

  const LiveOptions& options_;
  Stop& stop_;
  LiveSolver& solver_;
  LiveSource& source_;
  const decltype(LiveSetup::fit)& fit_;
  const ChannelMap& map_;
  LiveState& state_;
  Mailbox mailbox_;
  std::optional<LiveRecord> record_;
  SteadyClock::time_point start_ = SteadyClock::now();
  std::optional<StreamReader> reader_;
  LineOutput output_;
  std::optional<DatagramSender> sender_;
  LiveSummary summary_;
  Eigen::RowVectorXd background_sum_;
  Frames background_;  ///< the first most_judged of them
  int background_frames_ = 0;
  double last_time_s_ = 0;
  double last_heard_s_ = 0;
  bool silent_ = false;
  std::uint64_t damaged_said_ = 0;
  double damage_said_s_ = -damage_said_every_s;
};

std::optional<LiveServerOptions> server_options(const LiveOptions& options) {
  if (options.http.empty()) return std::nullopt;
  const auto [host, port] = host_and_port(options.http, "--http");
  if (!is_loopback(host)) {
    spdlog::warn(
        "--http {}: everybody who reaches this address sees the stream; there is no "
        "password and no encryption",
        options.http);
  }
  return LiveServerOptions{host, port, options.http_clients};
}

LiveSummary run_stream(const LiveOptions& options, SolverRegistry& registry) {
  const std::optional<LiveServerOptions> http = server_options(options);
  LiveSetup setup = live_setup(options, registry);
  std::signal(SIGPIPE, SIG_IGN);
  Stop stop;
  LiveState state({setup.solver_name, options.input, options.deadline_s, setup.solver->sensor()});
  Stream stream(options, setup, state, stop);
  std::optional<LiveServer> server;
  if (http) {
    server.emplace(*http, state);
    spdlog::info("watch it at {}", server->address());
  }
  if (!setup.checked) {
    spdlog::warn(
        "frames are checked for dead electrodes alone: the limits of noise and range need "
        "a solver that was fitted with an experiment's validation frames");
  }
  stream.say({{"event", "begin"},
              {"solver", setup.solver_name},
              {"input", options.input},
              {"channels", setup.solver->sensor().channels()},
              {"http", server ? json(server->address()) : json()},
              {"unix_time_s",
               std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
                   .count()}});
  return stream.run(setup.parameters);
}

}  // namespace

LiveSummary run_live(const LiveOptions& options, SolverRegistry& registry) {
  try {
    return run_stream(options, registry);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    if (options.experiment.empty()) blame_plugin(options.solver, options.plugin, error);
    throw;
  }
}

}  // namespace ertbench
