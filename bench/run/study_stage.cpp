#include "bench/run/study_stage.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/studies/study.h"

namespace ertbench {

std::string StudyStage::name() const { return "studies"; }

std::string StudyStage::noun() const { return "study"; }

std::vector<Job> StudyStage::jobs(const Experiment&) const { return {}; }

std::vector<Job> StudyStage::due(const Experiment&, const ExperimentResults&) const { return {}; }

std::string StudyStage::key(const Experiment&, const Job&) const {
  throw std::logic_error("studies have no jobs");
}

nlohmann::json StudyStage::run(const Job&, const JobContext&) const {
  throw std::logic_error("studies have no jobs");
}

void StudyStage::check(const Experiment&, const nlohmann::json&) const {
  throw std::logic_error("studies have no records");
}

void StudyStage::collect(const Experiment& experiment, const Cache& cache, const JobRecords&,
                         ExperimentResults& results) const {
  for (const StudySpec& spec : experiment.studies) {
    results.studies.push_back(
        {spec.name, spec.type, make_study({spec, experiment, results, cache})});
  }
}

std::vector<ReportSection> StudyStage::report(const Experiment& experiment,
                                              const ExperimentResults& results,
                                              const std::filesystem::path& folder) const {
  std::vector<ReportSection> sections;
  for (const StudyOutcome& study : results.studies) {
    for (ReportSection& section : study.result->report(experiment.title, folder)) {
      sections.push_back(std::move(section));
    }
  }
  return sections;
}

}  // namespace ertbench
