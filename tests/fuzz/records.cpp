// What trials leave for the run that started them: records of every stage, progress files, notes of
// fits, logs of trainings. A record that its stage takes goes the way of a run's results up to the
// tables, in the place of the second of two solvers.

#include <memory>

#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/ladder/ladder_results.h"
#include "bench/record/record_file.h"
#include "bench/report/differences.h"
#include "bench/report/result_table.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/run/runner.h"
#include "bench/table/table.h"
#include "bench/training/training_chart.h"
#include "core/json.h"
#include "solvers/registry/registry.h"
#include "tests/fuzz/fuzz_input.h"

namespace ertbench {
namespace {

using fuzzing::folder;
using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* experiment_text = R"({
  "sensor": {"image_grid": 8, "electrode_count": 8},
  "datasets": {
    "test": {"count": 4, "seed": 3, "grid": 8, "snr_db": 50, "snr_basis": "absolute",
             "scenes": {"contacts": 1, "shapes": ["disc"], "radius": 0.3}}
  },
  "solvers": [{"type": "tsvd", "rank": 5}, {"type": "one-step-gn", "lambda": 0.1}],
  "timing": {"rounds": 1},
  "figure": {"scenes": [0]},
  "ladders": {"dataset": "test",
              "axes": [{"name": "noise", "vary": "/snr_db", "levels": [60, 40]},
                       {"name": "shape", "vary": "/scenes/shapes", "scale": "categories", "levels": [["disc"], ["ring"]]},
                       {"name": "rank", "solver": "tsvd", "vary": "/rank", "levels": [9, 3]}]}
})";

/// A run whose first solver is done.
class Run {
 public:
  Run() {
    std::ofstream(folder() / "experiment.json") << experiment_text;
    experiment_ = read_experiment(folder() / "experiment.json", registry_, {});
    fs::create_directories(folder() / "results" / "records");
    ensure_datasets(experiment_, cache_);
    for (std::unique_ptr<Stage>& stage : stages_of_run(experiment_))
      stages_.push_back(std::move(stage));
    for (std::unique_ptr<Stage>& stage : stages_of_fidelity(10))
      stages_.push_back(std::move(stage));
    const Job first = stages_.front()->jobs(experiment_).front();
    const JobContext context{experiment_, cache_, registry_, 1, folder() / "progress"};
    put(*stages_.front(), first, stages_.front()->run(first, context));
  }

  void take(const json& record) {
    for (const std::unique_ptr<Stage>& stage : stages_) {
      try {
        stage->check(experiment_, record);
      } catch (const std::exception&) {
        continue;  // which is all that a stage promises of what is not its record
      }
      const Job job = stage->jobs(experiment_).back();
      put(*stage, job, record);
      finish(*stage);
      fs::remove(record_file(folder() / "results", job.name));
    }
  }

 private:
  void put(const Stage& stage, const Job& job, const json& record) const {
    write_record(record_file(folder() / "results", job.name), record, stage.key(experiment_, job),
                 stamp_of_record(experiment_, job.entry));
  }

  void finish(const Stage& stage) const {
    const JobRecords records(stage, experiment_, folder() / "results");
    ExperimentResults results;
    for (const SolverEntry& entry : experiment_.solvers) {
      results.labels[entry.label].scored = &entry;
    }
    stage.collect(experiment_, cache_, records, results);
    add_builds(stage, experiment_, records, results);
    show(results);
  }

  void show(const ExperimentResults& results) const {
    const Table table = result_table(results.rows, {});
    markdown_of(table);
    latex_of(table);
    csv_of(result_data(results.rows, {}));
    terminal_of(result_summary(results.rows));
    for (const ResultRow& row : results.rows) static_cast<void>(json_text(to_json(row)));
    for (const ScoredLabels& scored : results.frames) {
      markdown_of(difference_table(mean_differences(scored)));
    }
    const Ladders& ladders = *experiment_.ladders;
    const auto outcomes = results.findings.found<LadderOutcomes>();
    const std::vector<AxisBreakdown> breakdowns = breakdowns_of(ladders, outcomes);
    markdown_of(breakdown_table("", ladders, breakdowns));
    csv_of(levels_data(outcomes));
    markdown_of(detection_table("", ladders, detections_of(outcomes)));
    ladder_map_of("", breakdowns);
  }

  SolverRegistry registry_;
  Cache cache_{folder() / "cache"};
  Experiment experiment_;
  Stages stages_;
};

void read_log(const fs::path& file) {
  TrainingCurves curves;
  if (!fuzzing::accepted(file.string(), [&] { curves = read_training_curves(file); })) return;
  for (const std::vector<double>& column : curves.values) {
    fuzzing::require(column.size() == curves.epochs(),
                     "columns of a training log differ in length");
  }
}

}  // namespace
}  // namespace ertbench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  static Run run;
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "record");
  read_progress(file);
  read_log(file);
  json record;
  if (!fuzzing::accepted(file.string(), [&] { record = read_json_file(file); })) return 0;
  if (record.is_object()) build_stamp_from_json(record.value("build", json()));
  run.take(record);
  return 0;
}
