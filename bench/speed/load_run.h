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
  std::vector<std::string> only;  ///< labels; empty: all solvers
  std::size_t frames = 1000;      ///< smallest number of frames of a run
  std::uint64_t seed = 1;
  int threads = 1;  ///< for fits that are not cached; measurements use one
  /// Called after each solver, if set, since later ones may take minutes.
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

/// Service times of a solver and the rates it sustains.
struct SolverLoad {
  std::string label;
  std::string failure;  ///< why there is no result; otherwise empty
  double service_p50_s = 0;
  double service_p99_s = 0;
  double service_mean_s = 0;
  double lost_share = 0;  ///< share of the time that other processes took
  std::vector<DeadlineRates> deadlines;

  bool busy() const { return lost_share > busy_share; }
  static constexpr double busy_share = 0.02;
};

struct LoadResults {
  std::string experiment;
  std::string title;
  std::string dataset;  ///< whose frames arrive
  std::vector<double> deadlines_s;
  std::size_t frames = 0;
  std::uint64_t seed = 0;
  std::vector<SolverLoad> solvers;
};

/// Finds the highest rates of an experiment's solvers, one after the other in separate processes; a
/// solver that crashes loses only its own rates. The first of several seeds is taken. Throws
/// InputError if a label is unknown.
LoadResults run_load(const Experiment& experiment, const Cache& cache, SolverRegistry& registry,
                     const LoadOptions& options);

/// `{"label", "failure", "service_us": {"p50", "p99", "mean"}, "lost_share", "rates": [...]}`.
nlohmann::json to_json(const SolverLoad& load);
SolverLoad solver_load_from_json(const nlohmann::json& json);

/// One row per solver: the service times of a frame, then for each deadline the highest rates with
/// fixed and with Poisson arrivals.
Table load_table(const LoadResults& results);

/// Draws the rates over the deadlines, fixed arrivals on the left and Poisson ones on the right, as
/// `stem`.svg and `stem`.png. Returns false if it could not be drawn (draw_or_say).
bool draw_load(const LoadResults& results, const std::filesystem::path& stem);

/// Writes load.json, load.md, load.csv and the figure `load` into `folder`. Returns false if the
/// figure could not be drawn.
bool write_load(const LoadResults& results, const std::filesystem::path& folder);

}  // namespace ertbench
