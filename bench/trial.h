#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/cache.h"
#include "bench/experiment.h"
#include "bench/result_row.h"

namespace ertbench {

class SolverRegistry;

/// The two halves of a trial, each a process of its own: fitting, reconstructing and scoring may
/// share the machine with other trials; the clock wants it alone.
enum class Stage { accuracy, timing };

const char* name_of(Stage stage);

/// What determines a record; a record with the same key need not be made again.
std::string record_key(const Experiment& experiment, const SolverEntry& entry, Stage stage);

/// `folder`/records/`label`.accuracy.json and so on.
std::filesystem::path record_file(const std::filesystem::path& folder, const SolverEntry& entry,
                                  Stage stage);

/// The record of a finished stage, or nothing where there is none with the right key.
std::optional<nlohmann::json> read_record(const Experiment& experiment, const SolverEntry& entry,
                                          Stage stage, const std::filesystem::path& folder);

/// Fits the solver (or takes it from the cache), reconstructs every test set, scores each frame and
/// writes the record: `{"schema", "key", "fit_s", "rows", "frames": {dataset: {metric: [values],
/// "status", "iterations", "gap"}}, "figure_images": [[S/m]]}`. Datasets must be in the cache.
void run_accuracy_stage(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                        SolverRegistry& registry, int threads, const std::filesystem::path& folder);

/// Times the fitted solver on every test set: one frame at a time on one thread, then batches.
/// Writes `{"schema", "key", "timing": {dataset: {"latency_us": [every frame], "frames_per_s",
/// "batch"}}, "peak_rss_mb"}`.
void run_timing_stage(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                      SolverRegistry& registry, const std::filesystem::path& folder);

/// p50, p99 and maximum of every frame's time.
LatencySummary summarise_latency(std::vector<double> microseconds);

}  // namespace ertbench
