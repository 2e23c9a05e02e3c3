#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "bench/report/report.h"
#include "bench/report/result_table.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// A dataset in a sentence, for the tables' legends.
std::string description(const DatasetSpec& spec);

/// The page of an experiment whose charts have been drawn into `folder`: a table for each test set
/// and how to read it, the sections of the ladders, the charts, the reconstructions where there are
/// any, the training curves and where the numbers come from.
Report report_of(const Experiment& experiment, const std::vector<ResultRow>& rows,
                 const TableText& text, const std::vector<ReportFigure>& training_curves,
                 const std::vector<ReportSection>& ladders, const nlohmann::json& provenance,
                 const std::filesystem::path& folder);

}  // namespace ertbench
