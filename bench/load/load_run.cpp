#include "bench/load/load_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_solvers.h"
#include "bench/load/timed_server.h"
#include "bench/record/cache.h"
#include "bench/run/datasets.h"
#include "bench/run/fitted_solver.h"
#include "core/errors.h"
#include "core/json_text.h"
#include "core/process.h"
#include "core/quantile.h"
#include "core/temporary_folder.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr std::uint64_t most_frames_in_memory = 2000;
constexpr std::size_t service_frames = 1000;  ///< that are timed by themselves before

json to_json(const KeptRate& rate, const char* arrivals, double deadline_s) {
  json out = {{"deadline_s", deadline_s},
              {"arrivals", arrivals},
              {"frames_per_s", nullptr},
              {"runs", rate.runs}};
  if (rate.per_s) {
    out.update({{"frames_per_s", *rate.per_s},
                {"p99_s", rate.p99_s},
                {"confirmed", rate.confirmed},
                {"confirmed_p99_s", rate.confirmed_p99_s},
                {"utilisation", rate.utilisation},
                {"frames", rate.frames}});
  }
  return out;
}

KeptRate kept_rate_from_json(const json& value) {
  KeptRate out;
  out.runs = value.at("runs").get<int>();
  if (value.at("frames_per_s").is_null()) return out;
  out.per_s = value.at("frames_per_s").get<double>();
  out.p99_s = value.at("p99_s").get<double>();
  out.confirmed = value.at("confirmed").get<bool>();
  out.confirmed_p99_s = value.at("confirmed_p99_s").get<double>();
  out.utilisation = value.at("utilisation").get<double>();
  out.frames = value.at("frames").get<std::size_t>();
  return out;
}

/// In a process of its own. `progress` is told what is going on, also so that the process is not
/// taken for one that hangs.
SolverLoad measure(const Experiment& experiment, SolverEntry entry, const Cache& cache,
                   SolverRegistry& registry, const LoadOptions& options,
                   const std::function<void(const std::string&)>& progress) {
  registry.allow_plugins();
  describe(entry, registry.load(entry.type));
  const TemporaryFolder folder("load");
  const std::unique_ptr<Solver> solver =
      fitted_solver(fit_recipe(experiment, entry), cache, registry, options.threads,
                    folder / "progress")
          .solver;
  const DatasetFile set = cache.open_dataset(experiment.tests.front());
  const Frames voltages = set.voltages(0, std::min(set.size(), most_frames_in_memory));
  const Eigen::RowVectorXd reference = set.reference_voltages().transpose();
  TimedServer server(*solver, voltages, reference, experiment.sensor.pixels());

  SolverLoad out;
  out.label = entry.label;
  const std::vector<double> service_s = server.service_s(service_frames);
  out.service_p50_s = nearest_rank_quantile(service_s, 0.5);
  out.service_p99_s = nearest_rank_quantile(service_s, 0.99);
  out.service_mean_s =
      std::accumulate(service_s.begin(), service_s.end(), 0.0) / double(service_s.size());
  for (const double deadline_s : options.deadlines_s) {
    DeadlineRates rates;
    rates.deadline_s = deadline_s;
    for (const Arrivals arrivals : all_arrivals) {
      progress(number_text(1000 * deadline_s) + " ms, " + name_of(arrivals) + " arrivals");
      RateSearch search;
      search.arrivals = arrivals;
      search.deadline.seconds = deadline_s;
      search.least_frames = options.frames;
      search.seed = options.seed;
      (arrivals == Arrivals::fixed ? rates.fixed : rates.poisson) =
          highest_rate(search, service_s, server);
    }
    out.deadlines.push_back(rates);
  }
  out.lost_share = server.lost_share();
  return out;
}

SolverLoad measured_apart(const Experiment& experiment, const SolverEntry& entry,
                          const Cache& cache, SolverRegistry& registry,
                          const LoadOptions& options) {
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        json said;
        try {
          said = to_json(
              measure(experiment, entry, cache, registry, options, [&](const std::string& what) {
                std::fprintf(stderr, "%s: %s\n", entry.label.c_str(), what.c_str());
                send("{}");
              }));
        } catch (const std::exception& exception) {
          said = {{"failure", exception.what()}};
        }
        send(json_text(said));
      },
      {experiment.time_limit_s, machine_memory_bytes() / 10 * 9}, StandardError::shared);
  SolverLoad failed;
  failed.label = entry.label;
  failed.failure = outcome.end.text();
  if (!outcome.finished || outcome.messages.empty()) return failed;
  const json said = parse_json(outcome.messages.back(), "what the solver's process said");
  failed.failure = said.value("failure", std::string());
  return failed.failure.empty() ? solver_load_from_json(said) : failed;
}

/// One entry for each label that is asked for, the first seed.
std::vector<const SolverEntry*> entries_of(const Experiment& experiment,
                                           const std::vector<std::string>& only) {
  std::vector<const SolverEntry*> out;
  std::set<std::string> labels;
  for (const SolverEntry& entry : experiment.solvers) {
    const bool wanted =
        only.empty() || std::find(only.begin(), only.end(), entry.label) != only.end();
    if (labels.insert(entry.label).second && wanted) out.push_back(&entry);
  }
  for (const std::string& label : only) {
    if (labels.contains(label)) continue;
    std::string known;
    for (const std::string& one : labels) known.append(known.empty() ? "" : ", ").append(one);
    throw InputError("--only: no solver is called \"" + printable(label) + "\"; there are " +
                     known);
  }
  return out;
}

}  // namespace

json to_json(const SolverLoad& load) {
  json out = {{"label", load.label},
              {"failure", load.failure},
              {"service_us",
               {{"p50", 1e6 * load.service_p50_s},
                {"p99", 1e6 * load.service_p99_s},
                {"mean", 1e6 * load.service_mean_s}}},
              {"lost_share", load.lost_share},
              {"rates", json::array()}};
  for (const DeadlineRates& rates : load.deadlines) {
    for (const Arrivals arrivals : all_arrivals) {
      out["rates"].push_back(to_json(rates.of(arrivals), name_of(arrivals), rates.deadline_s));
    }
  }
  return out;
}

SolverLoad solver_load_from_json(const json& value) {
  SolverLoad out;
  out.label = value.at("label").get<std::string>();
  out.failure = value.at("failure").get<std::string>();
  const json& service = value.at("service_us");
  out.service_p50_s = 1e-6 * service.at("p50").get<double>();
  out.service_p99_s = 1e-6 * service.at("p99").get<double>();
  out.service_mean_s = 1e-6 * service.at("mean").get<double>();
  out.lost_share = value.at("lost_share").get<double>();
  for (const json& rate : value.at("rates")) {
    const auto deadline_s = rate.at("deadline_s").get<double>();
    if (out.deadlines.empty() || out.deadlines.back().deadline_s != deadline_s) {
      out.deadlines.push_back({deadline_s, {}, {}});
    }
    DeadlineRates& rates = out.deadlines.back();
    (rate.at("arrivals") == "fixed" ? rates.fixed : rates.poisson) = kept_rate_from_json(rate);
  }
  return out;
}

LoadResults run_load(const Experiment& experiment, const Cache& cache, SolverRegistry& registry,
                     const LoadOptions& options) {
  LoadResults out;
  out.experiment = experiment.name;
  out.title = experiment.title;
  out.dataset = experiment.tests.front().name;
  out.deadlines_s = options.deadlines_s;
  out.frames = options.frames;
  out.seed = options.seed;
  const std::vector<const SolverEntry*> entries = entries_of(experiment, options.only);
  ensure_datasets(experiment, cache);
  for (const SolverEntry* entry : entries) {
    out.solvers.push_back(measured_apart(experiment, *entry, cache, registry, options));
    if (options.finished) options.finished(out);
  }
  return out;
}

}  // namespace ertbench
