#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/cli/command.h"
#include "core/errors.h"
#include "core/text.h"
#include "live/live.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct LiveArguments {
  LiveOptions options;
  std::string format = "detect";
  double deadline_ms = 0;
};

ExitCode live(const LiveArguments& arguments) {
  LiveOptions options = arguments.options;
  options.format = *frame_format_named(arguments.format);
  options.deadline_s = arguments.deadline_ms / 1000;
  if (options.background > 0 && !options.reference.empty()) {
    throw InputError("--background and --reference: only one of them says what untouched is");
  }
  if (!options.sensor.empty() && !options.experiment.empty()) {
    throw InputError("--sensor: the experiment has a sensor already");
  }
  SolverRegistry registry;
  const LiveSummary summary = run_live(options, registry);
  const auto ms = [&](double share) {
    const std::optional<double> seconds = summary.latency.quantile_s(share);
    return seconds ? three_digits(1000 * *seconds) + " ms" : "–";
  };
  std::fprintf(stderr,
               "%s after %.1f s: %llu frames came, %llu answered, %llu dropped, %llu damaged; "
               "latency p50 %s, p99 %s, largest %s\n",
               summary.why.c_str(), summary.seconds,
               static_cast<unsigned long long>(summary.counts.came),
               static_cast<unsigned long long>(summary.counts.answered),
               static_cast<unsigned long long>(summary.counts.dropped),
               static_cast<unsigned long long>(summary.counts.all_damaged()), ms(0.5).c_str(),
               ms(0.99).c_str(), ms(1).c_str());
  return done;
}

}  // namespace

static Action add_live(CLI::App& command) {
  const auto arguments = std::make_shared<LiveArguments>();
  LiveOptions& options = arguments->options;
  command
      .add_option("--solver", options.solver,
                  "One entry of a \"solvers\" list, JSON, or a name that `list --fitted`\n"
                  "shows; with --experiment a label in it")
      ->required();
  command.add_option("--experiment", options.experiment,
                     "Experiment whose solver it is, from the cache or fitted and put there");
  command.add_option("--plugin", options.plugin, "Shared library of your own solvers");
  command
      .add_option("--input", options.input,
                  "-, udp://HOST:PORT, serial:DEVICE[@BAUD] or replay:FILE.h5[@RATE]")
      ->required();
  command.add_option("--format", arguments->format, "detect, binary or csv (default: detect)")
      ->check(CLI::IsMember({"detect", "binary", "csv"}));
  command.add_option("--channels", options.channels,
                     "Order of the sender's columns, as for `reconstruct` (default: the sensor's)");
  command.add_option("--unit", options.unit, "Of the sender: V, mV or uV (default: V)");
  command.add_flag(
      "--fix", options.fix,
      "Where the reference is not what the sensor's model expects, read the frames as\n"
      "would mend it");
  command
      .add_option_function<std::string>(
          "--difference",
          [&options](const std::string& kind) { options.normalised = kind == "normalised"; },
          "absolute (the default), or normalised: v / v0 times the model's v0")
      ->check(CLI::IsMember({"absolute", "normalised"}));
  command.add_flag("--force", options.force, "Image the frames whatever the check says");
  command.add_option("--sensor", options.sensor,
                     "Sensor, JSON (default: the experiment's, the file's, 16 electrodes)");
  command.add_option("--reference", options.reference,
                     "Of the untouched skin: a file with /reference_voltages, or \"model\"\n"
                     "(default: those of the file that is replayed)");
  command.add_option("--background", options.background, "The first so many frames are it")
      ->check(CLI::Range(1, 1000000));
  command
      .add_option("--floor", options.floor,
                  "Least change that is a contact, S/m (default: as the experiment chooses, or 0)")
      ->check(CLI::Range(0.0, 1e6));
  command.add_option("--forces", options.forces,
                     "Dataset of single touches with known forces: tells forces in N");
  command.add_flag(
      "--follow", options.follow,
      "Let the reference follow level and gradient of the sheet while nothing presses");
  command.add_option("--quiet", options.quiet,
                     "FILE.h5[@RATE] of frames in which nothing touches: tells collisions");
  command
      .add_option("--false-alarms", options.false_alarms_per_hour,
                  "That are allowed in an hour (default: 10)")
      ->check(CLI::Range(1e-6, 1e6));
  command.add_option("--repeat", options.repeat, "Replay the file so often (default: 1)")
      ->check(CLI::Range(1, 1000000));
  command
      .add_option("--queue", options.places,
                  "Frames that may wait before the oldest is dropped (default: 1)")
      ->check(CLI::Range(1, 100000));
  command.add_flag("--lossless", options.lossless, "Let the sender wait instead (- and replay:)");
  command
      .add_option("--silence", options.silence_s,
                  "Seconds without a frame after which that is said (default: 2)")
      ->check(CLI::Range(0.01, 1e6));
  command
      .add_option("--deadline", arguments->deadline_ms, "Of an answer, ms: later ones are counted")
      ->check(CLI::Range(1e-3, 1e6));
  command.add_option("--http", options.http, "HOST:PORT of a page to watch, 127.0.0.1:8080");
  command.add_option("--http-clients", options.http_clients, "That may watch (default: 4)")
      ->check(CLI::Range(1, 100));
  command.add_option("--record", options.record,
                     "HDF5 file of all that came and was answered; of what is there, only such a\n"
                     "file is written over");
  command.add_flag("--images", options.images, "Put the images into the lines, too");
  command.add_option("--send", options.send,
                     "udp://HOST:PORT that gets each answer as a datagram, too");
  command
      .add_option_function<std::string>(
          "--send-format",
          [arguments](const std::string& name) {
            arguments->options.send_binary = name == "binary";
          },
          "Of the datagrams: json, the line itself (default), or binary, a record that\n"
          "docs/live.md lists")
      ->check(CLI::IsMember({"json", "binary"}));
  command.add_option("--threads", options.threads, "While the solver is fitted (default: 1)")
      ->check(CLI::Range(1, 1024));
  command.footer(
      "Example:\n"
      "  echo '{\"type\": \"one-step-gn\", \"prior\": \"noser\", \"lambda\": 0.1}' > gn.json\n"
      "  ertbench generate experiments/quick.json --dataset test --out test.h5\n"
      "  ertbench live --solver gn.json --input replay:test.h5@125 --http 127.0.0.1:8080\n"
      "A line of JSON for each frame goes to standard output. See docs/live.md.");
  return [arguments] { return live(*arguments); };
}

}  // namespace ertbench

extern "C" void ertbench_part_live(ertbench::Part& part) {
  static constexpr ertbench::Command commands[] = {{"live", ertbench::add_live}};
  part.commands = commands;
}
