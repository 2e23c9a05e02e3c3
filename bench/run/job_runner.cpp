#include "bench/run/job_runner.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/experiment/experiment_solvers.h"
#include "bench/run/timing_stage.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/text.h"
#include "solvers/external/program.h"
#include "solvers/registry/registry.h"

namespace ertbench {

JobRecords::JobRecords(const Stage& stage, const Experiment& experiment,
                       std::filesystem::path folder, Reuse reuse)
    : stage_(stage), experiment_(experiment), folder_(std::move(folder)), reuse_(reuse) {}

std::filesystem::path JobRecords::file(const Job& job, const std::string& ending) const {
  return record_file(folder_, job.name, ending);
}

FoundRecord JobRecords::find(const Job& job) const {
  FoundRecord found = find_record(file(job), stage_.key(experiment_, job),
                                  stamp_of_record(experiment_, job.entry), reuse_);
  if (!found.record) return found;
  try {
    stage_.check(experiment_, *found.record);
  } catch (const std::exception& error) {
    return {JsonValue(), std::string("it cannot be read: ") + error.what()};
  }
  if (const std::string why = stage_.why_not_here(*found.record); !why.empty()) {
    return {JsonValue(), why};
  }
  return found;
}

bool JobRecords::accept(const Job& job) {
  const std::filesystem::path written = file(job, written_ending);
  if (!std::filesystem::exists(written)) return false;
  put_in_place(written, file(job));
  const bool good = has(job);
  if (good) expect(job);
  return good;
}

void JobRecords::discard(const Job& job) const {
  std::error_code ignored;
  std::filesystem::remove(file(job, written_ending), ignored);
}

std::optional<nlohmann::json> JobRecords::read(const Job& job) const {
  const FoundRecord found = find(job);
  if (found.record) return *found.record;
  if (expected_.count(job.name) > 0) {
    throw InputError(file(job).string() + ": was there a moment ago and cannot be read now" +
                     (found.why_not.empty() ? "" : ": " + found.why_not) +
                     "; give the same command again");
  }
  return std::nullopt;
}

void JobRecords::add_failure(const Job& job, Failure failure) {
  failures_.emplace(job.subject, std::move(failure));
}

const Failure* JobRecords::failure(const Job& job) const {
  const auto found = failures_.find(job.subject);
  return found == failures_.end() ? nullptr : &found->second;
}

Failure JobRecords::why_missing(const Job& job) const {
  const Failure* found = failure(job);
  return found ? *found : Failure{"not run", "left out by --only"};
}

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_failure_text = 2000;  ///< characters

std::string last_line(const fs::path& log) {
  std::ifstream in(log);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

Failure failure_of(const ProcessEnd& end, const fs::path& log, const ProcessLimits& limits) {
  if (end.timed_out) return {"timed out", "after " + duration_text(limits.time_s)};
  if (end.out_of_memory) {
    return {"out of memory", "needed more than " + std::to_string(limits.memory_bytes >> 20) +
                                 " MB (\"memory_limit_mb\")"};
  }
  if (end.signal != 0) return {"crashed", end.text() + "; see " + log.string()};
  if (end.ok()) return {"failed", "ended its process before it had a result"};
  const std::string line = last_line(log);
  return {"failed", line.empty() ? end.text() : line};
}

/// What a trial said of its own failure, if anything; removes the file.
std::optional<Failure> take_failure(const fs::path& file) {
  std::optional<Failure> failure;
  try {
    if (fs::exists(file)) {
      const nlohmann::json said = read_json_file(file);
      failure = Failure{printable(said.at("status").get<std::string>()),
                        printable(said.at("message").get<std::string>(), most_failure_text)};
    }
  } catch (const std::exception&) {  // whoever wrote it was not at his best
  }
  std::error_code ignored;
  fs::remove(file, ignored);
  return failure;
}

/// Fills in what the registration of the entry's type says, whose plugin this loads. What is wrong
/// with that the stage says, with the place in the file.
void describe_loaded(SolverEntry& entry, SolverRegistry& registry) {
  try {
    describe(entry, registry.load(entry.type));
  } catch (const InputError&) {
  }
}

}  // namespace

std::vector<Job> Stage::jobs(const Experiment& experiment) const {
  std::vector<Job> jobs;
  for (const SolverEntry& entry : experiment.solvers) jobs.push_back(job_of(*this, entry));
  return jobs;
}

Job job_of(const Stage& stage, const SolverEntry& entry) {
  return {entry.stem() + "." + stage.name(), entry.stem(), entry.title(), &entry, 0};
}

Job job_of(const Stage& stage, const SolverEntry& entry, int round) {
  Job job = job_of(stage, entry);
  job.name += "." + std::to_string(round);
  job.round = round;
  return job;
}

Job job_of(const Stage& stage, const DatasetSpec& dataset) {
  return {dataset.name + "." + stage.name(), dataset.name, "\"" + dataset.name + "\"", nullptr, 0};
}

JobRunner::JobRunner(const Stage& stage, const Experiment& experiment, const Cache& cache,
                     fs::path folder, JobRecords& records)
    : stage_(stage),
      experiment_(experiment),
      cache_(cache),
      folder_(std::move(folder)),
      records_(records),
      program_(fs::read_symlink("/proc/self/exe")) {}

void JobRunner::run(const std::vector<Job>& jobs, int at_a_time) {
  using Clock = std::chrono::steady_clock;
  std::deque<Job> waiting = without_records(jobs);
  const std::size_t total = waiting.size();
  if (total == 0) return;
  done_ = 0;
  Progress progress(stage_.name() + " of " + std::to_string(total) + " " + stage_.noun() +
                    (total == 1 ? "" : "s"));
  show(progress, total);
  Clock::time_point last_look = Clock::now();
  while (!waiting.empty() || !running_.empty()) {
    const std::size_t done_before = done_;
    start_some(waiting, static_cast<std::size_t>(at_a_time));
    finish_some();
    const Clock::time_point now = Clock::now();
    if (done_ != done_before || now - last_look > std::chrono::milliseconds(500)) {
      show(progress, total);
      last_look = now;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

std::deque<Job> JobRunner::without_records(const std::vector<Job>& jobs) const {
  std::deque<Job> out;
  std::map<std::string, int> reused;  // by what made them
  std::map<std::string, int> remade;  // by why
  const std::string program = stamp_of_this_build().program;
  for (const Job& job : jobs) {
    const FoundRecord found = records_.find(job);
    if (!found.record) {
      out.push_back(job);
      if (!found.why_not.empty()) ++remade[found.why_not];
      continue;
    }
    records_.expect(job);
    const auto build = build_stamp_from_json(found.record->at("build"));
    if (build->program != program) {
      ++reused["commit " + build->commit_text() + ", program " + build->program.substr(0, 8)];
    }
  }
  const auto records = [&](int count) {
    return stage_.name() + ": " + std::to_string(count) + (count == 1 ? " record" : " records");
  };
  for (const auto& [by, count] : reused) {
    spdlog::info("{} reused of an earlier build ({}), as nothing that they depend on has changed",
                 records(count), by);
  }
  for (const auto& [why, count] : remade) {
    spdlog::info("{} made again: {}", records(count), why);
  }
  return out;
}

void JobRunner::start_some(std::deque<Job>& waiting, std::size_t at_a_time) {
  while (!waiting.empty() && running_.size() < at_a_time) {
    const Job job = std::move(waiting.front());
    waiting.pop_front();
    if (job.entry && job.entry->failure) records_.add_failure(job, *job.entry->failure);
    if (records_.failure(job)) {  // just now, or in an earlier round
      ++done_;
      continue;
    }
    running_.push_back(start(job, at_a_time));
  }
}

ProcessLimits JobRunner::limits(std::size_t at_a_time) const {
  constexpr double share = 0.9;  // of the machine's memory
  const double part = threads_ ? std::min(1.0, *threads_ / static_cast<double>(usable_cores()))
                               : 1 / static_cast<double>(at_a_time);
  const double bytes = experiment_.memory_limit_mb
                           ? *experiment_.memory_limit_mb * (1 << 20)
                           : share * static_cast<double>(machine_memory_bytes()) * part;
  return {stage_.time_limit_s(experiment_), static_cast<std::uint64_t>(bytes)};
}

JobRunner::Running JobRunner::start(const Job& job, std::size_t at_a_time) const {
  remove_progress(records_.file(job, ".progress"));
  records_.discard(job);
  take_failure(records_.file(job, failure_ending));
  const std::size_t threads =
      threads_ ? static_cast<std::size_t>(*threads_)
               : std::max<std::size_t>(1, static_cast<std::size_t>(usable_cores()) / at_a_time);
  const ProcessLimits allowed = limits(at_a_time);
  std::vector<std::string> arguments = {program_.string(),
                                        "trial",
                                        experiment_.file.string(),
                                        "--stage=" + stage_.name(),
                                        "--job=" + job.name,
                                        "--out=" + folder_.string(),
                                        "--cache=" + cache_.folder().string(),
                                        std::string("--reuse=") + name_of(cache_.reuse()),
                                        "--threads=" + std::to_string(threads)};
  for (const std::string& one : experiment_.overrides) arguments.push_back("--set=" + one);
  const std::vector<std::string> options = stage_.options();
  arguments.insert(arguments.end(), options.begin(), options.end());
  return {job, allowed, ChildProcess(arguments, {records_.file(job, ".log")}, allowed)};
}

void JobRunner::finish_some() {
  for (auto one = running_.begin(); one != running_.end();) {
    const auto end = one->process.poll();
    if (!end) {
      ++one;
      continue;
    }
    finish(*one, *end);
    one = running_.erase(one);
    ++done_;
  }
}

void JobRunner::finish(const Running& one, const ProcessEnd& end) {
  const Job& job = one.job;
  remove_progress(records_.file(job, ".progress"));
  if (end.ok() && records_.accept(job)) return;
  records_.discard(job);
  // What a process left in the cache whose memory was no longer what it should be.
  if (end.signal != 0 && !end.timed_out && !end.out_of_memory) {
    stage_.forget(experiment_, cache_, job);
  }
  const std::optional<Failure> said = take_failure(records_.file(job, failure_ending));
  const Failure failure = said && end.exit_code > 0 && !end.timed_out && !end.out_of_memory
                              ? *said
                              : failure_of(end, records_.file(job, ".log"), one.limits);
  spdlog::warn("{} ({}): {}: {}", job.title, stage_.name(), failure.status, failure.message);
  records_.add_failure(job, failure);
}

/// A job that runs counts by what it has done.
void JobRunner::show(Progress& progress, std::size_t total) const {
  constexpr double parts = 1000;
  double sum = static_cast<double>(done_);
  std::string text;
  for (const Running& one : running_) {
    text += (text.empty() ? "" : "; ") + one.job.title;
    const auto state = read_progress(records_.file(one.job, ".progress"));
    if (!state) continue;
    sum += std::clamp(state->fraction, 0.0, 1.0);
    if (!state->text.empty()) text += " " + state->text;
    if (state->seconds_left > 0) text += ", " + duration_text(state->seconds_left) + " left";
  }
  progress.update(static_cast<std::uint64_t>(parts * sum),
                  static_cast<std::uint64_t>(parts) * total, text);
}

void run_trial(const Stage& stage, const std::string& name, Experiment& experiment,
               const Cache& cache, SolverRegistry& registry, int threads,
               const std::filesystem::path& folder) {
  const std::vector<Job> jobs = stage.jobs(experiment);
  const auto job = std::ranges::find(jobs, name, &Job::name);
  if (job == jobs.end()) {
    throw InputError("--job: the stage " + stage.name() + " has no job \"" + printable(name) +
                     "\"");
  }
  registry.allow_plugins();  // this process is there for nothing else
  for (SolverEntry& entry : experiment.solvers) {
    if (&entry == job->entry) describe_loaded(entry, registry);
  }
  const JobContext context{experiment, cache, registry, threads,
                           record_file(folder, name, ".progress")};
  try {
    const nlohmann::json result = stage.run(*job, context);
    require_programs_ended_well();
    write_record(record_file(folder, name, written_ending), result, stage.key(experiment, *job),
                 stamp_of_record(experiment, job->entry));
  } catch (const FailedTrial& failed) {
    write_file_atomically(
        record_file(folder, name, failure_ending),
        json_text({{"status", failed.status()}, {"message", std::string(failed.what())}}));
    throw;
  }
}

}  // namespace ertbench
