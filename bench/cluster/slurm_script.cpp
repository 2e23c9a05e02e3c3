#include <filesystem>

#include "bench/cluster/slurm_engine.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// As one word of a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// For sbatch, which replaces "%j" and the like in names of files.
std::string without_patterns(const std::string& path) {
  std::string out;
  for (const char c : path) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

}  // namespace

std::string slurm_script(const Experiment& experiment, const Cache& cache,
                         const SlurmOptions& options, const std::string& part, std::size_t elements,
                         bool exclusive, const fs::path& list) {
  TextStream out;
  // Quotes keep spaces together.
  const auto option = [&](const std::string& text) { out << "#SBATCH \"--" << text << "\"\n"; };
  out << "#!/bin/sh\n";
  option("job-name=ertbench-" + experiment.name + "-" + part);
  option("output=" + without_patterns(list.parent_path().string() + "/" + list.stem().string()) +
         ".%a.log");
  option("open-mode=append");
  // A node that goes down, or a job of higher rank, sends an element back into the queue; what it
  // had finished has its records.
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
  out << "\"\n\ncd " << quoted(fs::current_path().string()) << " &&\nexec "
      << quoted(fs::read_symlink("/proc/self/exe").string()) << " element "
      << quoted(experiment.file.string());
  for (const std::string& one : experiment.overrides) out << " --set " << quoted(one);
  out << " \\\n  --list " << quoted(list.string()) << " --element \"$SLURM_ARRAY_TASK_ID\" \\\n"
      << "  --out " << quoted(fs::absolute(options.out).string()) << " --cache "
      << quoted(fs::absolute(cache.folder()).string()) << " --reuse " << name_of(cache.reuse())
      << " --threads " << options.threads << "\n";
  return out.str();
}

}  // namespace ertbench
