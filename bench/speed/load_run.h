#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/speed/offered_load.h"
#include "bench/table/table.h"

namespace ertbench {

class Cache;
class SolverRegistry;
struct Experiment;
struct LoadResults;

struct LoadOptions {
  std::vector<double> deadlines_s = {0.001, 0.005, 0.02};
  std::vector<std::string> only;  ///< labels; none: all solvers
  std::size_t frames = 1000;      ///< of a run, at least
  std::uint64_t seed = 1;
  int threads = 1;  ///< of fits that are not in the cache; the measuring has one
  /// Where set, called after each solver with what there is so far: the last ones may take minutes.
  std::function<void(const LoadResults& so_far)> finished;
};

/// The rates of one solver under one deadline.
struct DeadlineRates {
  double deadline_s = 0;
  KeptRate fixed;
  KeptRate poisson;

  const KeptRate& of(Arrivals arrivals) const {
    return arrivals == Arrivals::fixed ? fixed : poisson;
  }
};

/// One solver, and what it keeps.
struct SolverLoad {
  std::string label;
  std::string failure;  ///< why there is nothing else; else empty
  double service_p50_s = 0;
  double service_p99_s = 0;
  double service_mean_s = 0;
  double lost_share = 0;  ///< of the time, to whatever else the machine was busy with
  std::vector<DeadlineRates> deadlines;

  bool busy() const { return lost_share > busy_share; }
  static constexpr double busy_share = 0.02;
};

/// All that was measured.
struct LoadResults {
  std::string experiment;
  std::string title;
  std::string dataset;  ///< whose frames arrive
  std::vector<double> deadlines_s;
  std::size_t frames = 0;
  std::uint64_t seed = 0;
  std::vector<SolverLoad> solvers;
};

/// Searches the highest rates of an experiment's solvers, each in a process of its own, one after
/// the other; a solver that crashes costs its own rates. Of several seeds of a label the first is
/// taken. Throws InputError where a label is unknown.
LoadResults run_load(const Experiment& experiment, const Cache& cache, SolverRegistry& registry,
                     const LoadOptions& options);

/// `{"label", "failure", "service_us": {"p50", "p99", "mean"}, "lost_share", "rates": [...]}`.
nlohmann::json to_json(const SolverLoad& load);
SolverLoad solver_load_from_json(const nlohmann::json& json);

/// A row for each solver: the times of a frame by itself, then for each deadline the highest rates
/// with fixed and with Poisson arrivals.
Table load_table(const LoadResults& results);

/// The rates over the deadlines, arrivals at a fixed rate on the left and Poisson ones on the
/// right, as `stem`.svg and `stem`.png. Returns whether it was drawn (draw_or_say).
bool draw_load(const LoadResults& results, const std::filesystem::path& stem);

/// load.json, load.md, load.csv and the figure `load` in `folder`. Returns whether it was drawn.
bool write_load(const LoadResults& results, const std::filesystem::path& folder);

}  // namespace ertbench
