#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/cluster/slurm.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {

using nlohmann::json;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Submission, job, part, elements)

Submissions::Submissions(const std::filesystem::path& folder) : file_(folder / "submitted.json") {
  if (!std::filesystem::exists(file_)) return;
  try {
    all_ = read_json_file(file_).at("submissions").get<std::vector<Submission>>();
  } catch (const std::exception& error) {
    throw InputError(file_.string() + ": cannot be read (" + error.what() +
                     "); end the experiment's jobs (scancel) and remove the file");
  }
}

void Submissions::add(Submission one) {
  all_.push_back(std::move(one));
  write_file_atomically(file_, json_text(json{{"schema", 1}, {"submissions", all_}}));
}

std::vector<long> Submissions::jobs() const { return distinct(all_, &Submission::job); }

std::vector<long> Submissions::jobs_of(const std::vector<std::string>& parts) const {
  std::vector<long> out;
  for (const Submission& one : all_) {
    if (contains(parts, one.part)) out.push_back(one.job);
  }
  return out;
}

const Submission* Submissions::find(long job) const {
  const auto found = std::ranges::find(all_, job, &Submission::job);
  return found == all_.end() ? nullptr : &*found;
}

LiveUnits Submissions::units_of(const std::vector<SlurmTask>& tasks) const {
  LiveUnits live;
  for (const SlurmTask& task : tasks) {
    const Submission* one = find(task.job);
    if (!one) continue;
    const auto element = static_cast<std::size_t>(task.element.value_or(0));
    if (element >= one->elements.size()) continue;
    for (const std::string& unit : one->elements[element]) live.emplace(one->part, unit);
  }
  return live;
}

void Submissions::keep(const std::vector<SlurmTask>& live) {
  std::erase_if(all_, [&](const Submission& one) {
    return std::ranges::find(live, one.job, &SlurmTask::job) == live.end();
  });
}

namespace {

namespace fs = std::filesystem;

/// Parts whose jobs use results of earlier parts, and are planned again if there are more of these.
const std::vector<std::string> later_parts = {"timing", "ladders", "report"};

class Engine {
 public:
  Engine(const Experiment& experiment, const Cache& cache, const SlurmOptions& options)
      : experiment_(experiment),
        cache_(cache),
        options_(options),
        folder_(fs::absolute(options.out) / "slurm"),
        submissions_(folder_) {}

  SlurmOutcome run() {
    const std::vector<SlurmPart> parts = plan();
    if (options_.dry_run) {
      for (const SlurmPart& part : parts) print(part);
      return {true, 0};
    }
    fs::create_directories(folder_);
    fs::create_directories(options_.out / "records");
    fs::create_directories(cache_.folder() / "datasets");
    fs::remove(folder_ / "outcome.json");
    for (const SlurmPart& part : parts) submit_part(part);
    watch();
    return outcome();
  }

 private:
  /// Plans what is missing and neither waits nor runs. Jobs that wait for units submitted again are
  /// cancelled and planned with the rest.
  std::vector<SlurmPart> plan() {
    live_ = live_tasks(submissions_.jobs());
    submissions_.keep(live_);
    std::vector<SlurmTask> kept = live_;
    std::erase_if(kept, [&](const SlurmTask& task) {
      const std::string& part = submissions_.find(task.job)->part;
      return task.waits() && contains(later_parts, part);
    });
    std::vector<SlurmPart> parts =
        slurm_plan(experiment_, cache_, submissions_.units_of(kept), options_, most_elements());
    std::vector<long> withdrawn;
    for (const SlurmTask& task : live_) {
      if (std::ranges::find(kept, task.job, &SlurmTask::job) == kept.end()) {
        withdrawn.push_back(task.job);
      }
    }
    if (!options_.dry_run) {
      cancel(withdrawn);
      submissions_.keep(kept);
    }
    live_ = kept;
    if (!live_.empty()) {
      spdlog::info("slurm: {} tasks of an earlier command wait or run", live_.size());
    }
    return parts;
  }

  /// "afterok:12:14", naming the jobs whose results the part needs; empty if there are none.
  std::string dependency_of(const std::string& part) const {
    std::vector<std::string> before = {"datasets"};
    if (part == "timing" || part == "ladders") before = {"accuracy"};
    if (part == "report") before = {"datasets", "accuracy", "folds", "timing", "ladders"};
    if (part == "datasets") return "";
    std::string out;
    if (options_.dry_run) {
      for (const std::string& one : before) {
        if (printed_.count(one) > 0) out += ":$" + one;
      }
    } else {
      for (const long job : submissions_.jobs_of(before)) out += ":" + std::to_string(job);
    }
    // Fits need all datasets; other parts use whatever exists.
    if (out.empty()) return "";
    return (part == "accuracy" ? "afterok" : "afterany") + out;
  }

  std::vector<std::string> command_of(const std::string& part) const {
    std::vector<std::string> command = {"sbatch", "--parsable"};
    const std::string dependency = dependency_of(part);
    if (!dependency.empty()) {
      command.push_back("--dependency=" + dependency);
      command.emplace_back("--kill-on-invalid-dep=yes");
    }
    return command;
  }

  /// OUT/slurm/3.accuracy.json, with the first free number.
  fs::path free_list(const std::string& part) const {
    for (int number = 1;; ++number) {
      fs::path list = folder_ / (std::to_string(number) + "." + part + ".json");
      if (!fs::exists(list)) return list;
    }
  }

  std::string script_of(const SlurmPart& part, const fs::path& list) const {
    return slurm_script(experiment_, cache_, options_, part.name, part.elements.size(),
                        part.exclusive, list);
  }

  void print(const SlurmPart& part) {
    const fs::path list = folder_ / ("1." + part.name + ".json");
    std::string line;
    for (const std::string& word : command_of(part.name)) line += word + " ";
    std::printf("# %s: %zu element%s; %s holds their units\n%s=$(%s<<'END'\n%sEND\n)\n\n",
                part.name.c_str(), part.elements.size(), part.elements.size() == 1 ? "" : "s",
                printable_path(list.string()).c_str(), part.name.c_str(), line.c_str(),
                printable_lines(script_of(part, list)).c_str());
    printed_.insert(part.name);
  }

  void submit_part(const SlurmPart& part) {
    const fs::path list = free_list(part.name);
    const json content = {{"part", part.name},
                          {"elements", part.elements},
                          {"only", options_.only},
                          {"command", options_.command}};
    write_file_atomically(list, json_text(content));
    const fs::path script = fs::path(list).replace_extension(".sh");
    write_file_atomically(script, script_of(part, list));
    std::vector<std::string> command = command_of(part.name);
    command.push_back(script.string());
    const long job = submit(command);
    submissions_.add({job, part.name, part.elements});
    if (part.name == "report") report_log_ = list.parent_path() / (list.stem().string() + ".0.log");
    spdlog::info("slurm: {}: {} element{} as job {}", part.name, part.elements.size(),
                 part.elements.size() == 1 ? "" : "s", job);
  }

  /// "accuracy: 2 run (dd-ert on node7, tsvd on node8), 30 wait"
  std::string state_of(const std::vector<SlurmTask>& tasks) const {
    constexpr int most_named = 4;
    std::map<std::string, std::pair<int, int>> counts;  // running, waiting
    std::map<std::string, std::string> named;
    for (const SlurmTask& task : tasks) {
      const Submission* one = submissions_.find(task.job);
      auto& [running, waiting] = counts[one->part];
      if (task.waits()) {
        ++waiting;
        continue;
      }
      if (++running > most_named) continue;
      const Units& units = one->elements.at(static_cast<std::size_t>(task.element.value_or(0)));
      std::string& text = named[one->part];
      text += (text.empty() ? "" : ", ") + (units.empty() ? std::string("it") : units.front());
      if (units.size() > 1) text += " and " + std::to_string(units.size() - 1) + " more";
      text += " on " + task.node;
    }
    std::string out;
    for (const auto& [part, count] : counts) {
      out += (out.empty() ? "" : "; ") + part + ":";
      if (count.first > 0) {
        out += " " + std::to_string(count.first) + " run (" + named[part] +
               (count.first > most_named ? ", ...)" : ")");
      }
      if (count.second > 0) {
        out += (count.first > 0 ? ", " : " ") + std::to_string(count.second) + " wait";
      }
    }
    return out;
  }

  /// Asks the controller at growing intervals, so that many watchers do not load it.
  void watch() {
    using namespace std::chrono_literals;
    spdlog::info(
        "slurm: this program only watches: ended, the jobs go on, and the same command "
        "watches again");
    std::string last;
    auto pause = std::chrono::milliseconds(1000);
    for (;;) {
      const std::vector<SlurmTask> tasks = live_tasks(submissions_.jobs());
      if (tasks.empty()) return;
      const std::string state = state_of(tasks);
      if (state != last) {
        spdlog::info("slurm: {}", printable(state, 500));
        last = state;
      }
      std::this_thread::sleep_for(pause);
      pause = std::min<std::chrono::milliseconds>(pause * 5 / 4, 20s);
    }
  }

  SlurmOutcome outcome() const {
    const fs::path file = folder_ / "outcome.json";
    const std::string said = contents_of(report_log_);
    if (!fs::exists(file)) {
      spdlog::error("slurm: the report was not made: {}",
                    said.empty() ? "its job was ended" : one_line(said, 300));
      spdlog::error("slurm: give the same command again; what is finished is not done twice");
      return {false, 0};
    }
    std::fputs(printable_lines(said).c_str(), stdout);
    const json content = read_json_file(file);
    return {true, content.at("failures").get<int>() + content.at("undrawn").get<int>()};
  }

  const Experiment& experiment_;
  const Cache& cache_;
  const SlurmOptions& options_;
  fs::path folder_;
  Submissions submissions_;
  std::vector<SlurmTask> live_;
  std::set<std::string> printed_;  ///< parts of a dry run
  fs::path report_log_;
};

}  // namespace

SlurmOutcome run_on_slurm(const Experiment& experiment, const Cache& cache,
                          const SlurmOptions& options) {
  return Engine(experiment, cache, options).run();
}

std::string slurm_script(const Experiment& experiment, const Cache& cache,
                         const SlurmOptions& options, const std::string& part, std::size_t elements,
                         bool exclusive, const fs::path& list) {
  TextStream out;
  // Quotes keep spaces together.
  const auto option = [&](const std::string& text) { out << "#SBATCH \"--" << text << "\"\n"; };
  out << "#!/bin/sh\n";
  option("job-name=ertbench-" + experiment.name + "-" + part);
  // sbatch replaces "%j" and the like in file names.
  option("output=" + replaced(list.parent_path().string() + "/" + list.stem().string(), "%", "%%") +
         ".%a.log");
  option("open-mode=append");
  // A failed node or preemption requeues an element; its finished units have records.
  option("requeue");
  option("nodes=1");
  option("ntasks=1");
  if (exclusive) {
    option("exclusive");
  } else {
    option("cpus-per-task=" + std::to_string(options.threads));
    if (experiment.memory_limit_mb && part != "report" && part != "datasets") {
      constexpr int around_mb = 512;  // the program around the trial, and its supervisor
      option("mem=" + std::to_string(static_cast<long>(*experiment.memory_limit_mb) + around_mb) +
             "M");
    }
  }
  if (!options.partition.empty()) option("partition=" + options.partition);
  if (!options.time.empty()) option("time=" + options.time);
  if (!options.account.empty()) option("account=" + options.account);
  out << "#SBATCH \"--array=0-" << elements - 1;
  if (options.array_limit > 0) out << "%" << options.array_limit;
  out << "\"\n\ncd " << shell_quoted(fs::current_path().string()) << " &&\nexec "
      << shell_quoted(fs::read_symlink("/proc/self/exe").string()) << " element "
      << shell_quoted(experiment.file.string());
  for (const std::string& one : experiment.overrides) out << " --set " << shell_quoted(one);
  out << " \\\n  --list " << shell_quoted(list.string())
      << " --element \"$SLURM_ARRAY_TASK_ID\" \\\n"
      << "  --out " << shell_quoted(fs::absolute(options.out).string()) << " --cache "
      << shell_quoted(fs::absolute(cache.folder()).string()) << " --reuse "
      << name_of(cache.reuse()) << " --threads " << options.threads << "\n";
  return out.str();
}

}  // namespace ertbench
