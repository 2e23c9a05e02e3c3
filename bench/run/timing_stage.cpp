#include "bench/run/timing_stage.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "bench/record/measurement_records.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/run/rows.h"
#include "bench/score/image_contacts.h"
#include "core/seconds.h"
#include "core/statistics.h"
#include "core/supervisor.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// The first line of /proc/stat: user, nice, system, idle, iowait, irq, softirq and steal, in ticks
/// (proc(5)). Time that another guest of the same host stole disturbs as much.
double machine_busy_s() {
  std::ifstream in("/proc/stat");
  std::string word;
  in >> word;
  double busy = 0;
  for (int column = 0; column < 8; ++column) {
    double ticks = 0;
    in >> ticks;
    if (column != 3 && column != 4) busy += ticks;
  }
  return in ? busy / static_cast<double>(::sysconf(_SC_CLK_TCK)) : 0;
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

rusage own_usage() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage;
}

double process_s() {
  const rusage usage = own_usage();
  return seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
}

using Clock = SteadyClock;

/// The frames of one test set, in memory, and a solver to be timed on them.
class TimedSet {
 public:
  TimedSet(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
           const TimingSettings& timing)
      : solver_(solver),
        sensor_(sensor),
        pixels_(sensor.pixels()),
        timing_(timing),
        voltages_(set.voltages(
            0, std::min<std::uint64_t>(set.size(), static_cast<std::uint64_t>(timing.frames)))),
        sequences_(set.sequences(0, static_cast<std::uint64_t>(voltages_.rows()))),
        reference_(set.reference_voltages().transpose()) {}

  /// One by one the frames `first` to `last` - 1, again from the beginning where the set has fewer;
  /// µs each, from the raw voltages to the finished image. Those of sequences in a stream, as a
  /// robot has them. With a rule to the contacts, which the solver finds or the rule reads: 20
  /// frames, and more as far as the round's share of a second has room for them.
  std::vector<double> latencies(int first, int last, const ContactRule* rule = nullptr) const {
    Frames change(1, voltages_.cols());
    Images image(1, pixels_);
    std::unique_ptr<FrameStream> stream;
    const auto begin_stream = [&](int frame) {
      if (sequences_.size() > 0 && (!stream || sequence_of(frame) != sequence_of(frame - 1))) {
        stream = solver_.open_stream();
      }
    };
    ContactReader reader(sensor_);
    std::vector<FoundContact> found;
    const ContactFinder* const finder = rule ? solver_.contact_finder() : nullptr;
    const auto one_frame = [&](Eigen::Index frame) {
      FrameReport report;
      change = voltages_.row(frame % voltages_.rows()) - reference_;
      if (finder && !stream) {
        found.clear();
        finder->find_contacts(change, {&found, 1});
        return;
      }
      if (stream) {
        stream->reconstruct(change, image, {&report, 1});
      } else {
        solver_.reconstruct(change, image, {&report, 1});
      }
      if (!rule || (stream && stream->contacts())) return;
      if (report.status != FrameStatus::undefined) reader.read(*rule, image.row(0), found);
    };
    for (int i = 0; i < timing_.warm_up; ++i) {
      begin_stream(first + i);
      one_frame(first + i);
    }
    stream.reset();
    std::vector<double> microseconds;
    const Clock::time_point begin = Clock::now();
    for (int i = first; i < last; ++i) {
      if (rule && i >= first + 20 && seconds_since(begin) > 1.0 / timing_.rounds) break;
      begin_stream(i);
      const Clock::time_point start = Clock::now();
      one_frame(i);
      microseconds.push_back(1e6 * seconds_since(start));
    }
    return microseconds;
  }

  /// Of the batches that the round's share of a second has room for, one at least after one as
  /// warm-up, the median.
  double frames_per_s() const {
    Frames batch(timing_.batch, voltages_.cols());
    Frames changes(timing_.batch, voltages_.cols());
    Images images(timing_.batch, pixels_);
    for (Eigen::Index i = 0; i < batch.rows(); ++i) {
      batch.row(i) = voltages_.row(i % voltages_.rows());
    }
    std::vector<FrameReport> reports(static_cast<std::size_t>(timing_.batch));
    std::vector<double> batch_s;
    const auto one_batch = [&] {
      const Clock::time_point start = Clock::now();
      changes = batch.rowwise() - reference_;
      std::ranges::fill(reports, FrameReport{});
      solver_.reconstruct(changes, images, reports);
      return seconds_since(start);
    };
    one_batch();
    const Clock::time_point begin = Clock::now();
    do {
      batch_s.push_back(one_batch());
    } while (seconds_since(begin) < 1.0 / timing_.rounds && batch_s.size() < 1000);
    return timing_.batch / median(batch_s);
  }

 private:
  /// Of the frame with this number, which may be beyond the set or -1.
  double sequence_of(int frame) const {
    const Eigen::Index frames = voltages_.rows();
    return sequences_[(frame + frames) % frames];
  }

  const Solver& solver_;
  const Sensor& sensor_;
  int pixels_;
  const TimingSettings& timing_;
  Frames voltages_;               ///< [frames, channels] V
  Eigen::VectorXd sequences_;     ///< [frames], or empty where they do not move
  Eigen::RowVectorXd reference_;  ///< [channels] V
};

/// What the programs that solvers run in hold at this moment, beside our own memory. Each has a
/// supervisor, a copy of ours that does not count.
double programs_rss_mb() {
  double bytes = 0;
  for (const pid_t supervisor : children_of(::getpid())) {
    bytes += static_cast<double>(resident_bytes_below(supervisor));
  }
  return bytes / (1 << 20);
}

class TimingStage final : public Stage {
 public:
  explicit TimingStage(Machines machines) : machines_(machines) {}
  bool wants_machine_alone() const override { return true; }
  bool in_one_session() const override { return true; }
  std::string name() const override { return "timing"; }
  std::string noun() const override { return "round"; }
  std::vector<Job> jobs(const Experiment& experiment) const override {
    std::vector<Job> jobs;
    for (int round = 0; round < experiment.timing.rounds; ++round) {
      for (const SolverEntry& entry : experiment.solvers) {
        jobs.push_back(job_of(*this, entry, round));
      }
    }
    return jobs;
  }
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override {
    if (!experiment.timing.enabled) return {};
    std::vector<Job> due = jobs(experiment);
    std::erase_if(due, [&](const Job& job) {
      return results.labels.at(job.entry->label).scored != job.entry;
    });
    return due;
  }
  std::string key(const Experiment& experiment, const Job& job) const override {
    return timing_key(experiment, *job.entry);
  }
  json run(const Job& job, const JobContext& context) const override {
    const Experiment& experiment = context.experiment;
    const TimingSettings& timing = experiment.timing;
    const FittedSolver fitted = fitted_solver(fit_recipe(experiment, *job.entry), context.cache,
                                              context.registry, 1, context.progress_file);
    const int first = job.round * timing.frames / timing.rounds;
    const int last = (job.round + 1) * timing.frames / timing.rounds;
    // What the validation set would choose takes about as long as the defaults.
    const ContactRule rule = experiment.contacts.rule();
    const MachineLoad load;
    json record = {{"schema", record_schema}, {"calibration_us", calibration_us()}};
    for (const DatasetSpec& test : experiment.tests) {
      const DatasetFile file = context.cache.open_dataset(test);
      const TimedSet set(*fitted.solver, file, experiment.sensor, timing);
      const std::vector<double> latencies = set.latencies(first, last);
      json& times = record["timing"][test.name];
      times = {
          {"latency_us", latencies}, {"frames_per_s", set.frames_per_s()}, {"batch", timing.batch}};
      times["contacts_us"] = set.latencies(first, last, &rule);
      if (const std::unique_ptr<Solver> transport = fitted.solver->transport()) {
        const TimedSet alone(*transport, file, experiment.sensor, timing);
        times["pipe_us"] = alone.latencies(first, last);
      }
    }
    record["place"] = to_json(TimingPlace{cpu_name(), host_name(), load.others_cores()});
    record["peak_rss_mb"] = static_cast<double>(own_usage().ru_maxrss) / 1024 + programs_rss_mb();
    return record;
  }
  void check(const Experiment&, const json& record) const override {
    timing_record_from_json({record});
  }
  std::string why_not_here(const json& record) const override {
    const std::string cpu = timing_place_of(record).cpu;
    if (machines_ == Machines::any || cpu == cpu_name()) return "";
    return "it was timed on another processor (" + printable(cpu) + ")";
  }
  void collect(const Experiment& experiment, const Cache&, const JobRecords& records,
               ExperimentResults& results) const override {
    if (!experiment.timing.enabled) return;
    for (const std::span<const SolverEntry> entries : experiment.rows()) {
      std::vector<TimedTrial> trials;
      for (const SolverEntry& entry : entries) {
        TimedTrial& trial = trials.emplace_back();
        trial.entry = &entry;
        std::vector<json> rounds;
        for (int round = 0; round < experiment.timing.rounds; ++round) {
          const Job job = job_of(*this, entry, round);
          if (const Failure* failure = records.failure(job)) trial.failure = *failure;
          std::optional<json> record = records.read(job);
          if (!record) break;
          rounds.push_back(std::move(*record));
        }
        if (std::ssize(rounds) == experiment.timing.rounds) {
          trial.timing = timing_record_from_json(rounds);
        }
      }
      for (ResultRow& row : results.rows) {
        if (row.label == entries.front().label) add_times(trials, row);
      }
    }
  }

 private:
  Machines machines_;
};

}  // namespace

int usable_cores() {
  cpu_set_t set;
  // Fails where the machine has more processors than a set of this size.
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

MachineLoad::MachineLoad() : busy_s_(machine_busy_s()), own_s_(process_s()), start_(Clock::now()) {}

double MachineLoad::others_cores() const {
  constexpr double least_s = 0.1;  // ten ticks: less time does not resolve a tenth of a core
  const double elapsed = seconds_since(start_);
  if (elapsed < least_s) return 0;
  const double others = machine_busy_s() - busy_s_ - (process_s() - own_s_);
  return std::max(0.0, others / elapsed);
}

double calibration_us() {
  constexpr int warm_up = 200;
  constexpr int measured = 1001;
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Constant(576, 104, 1.0 / 104);
  Eigen::VectorXd in = Eigen::VectorXd::Ones(104);
  Eigen::VectorXd out(576);
  std::vector<double> microseconds;
  for (int i = 0; i < warm_up + measured; ++i) {
    const Clock::time_point start = Clock::now();
    out.noalias() = matrix * in;
    in[i % 104] = out[i % 576];  // the next product waits for this one
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    if (i >= warm_up) microseconds.push_back(time.count());
  }
  return median(microseconds);
}

std::unique_ptr<Stage> timing_stage(Machines machines) {
  return std::make_unique<TimingStage>(machines);
}

}  // namespace ertbench
