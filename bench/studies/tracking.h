#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/studies/study.h"
#include "bench/studies/tracking_run.h"

namespace ertbench {

/// D.4: along which path? A finger writes characters; the places that a solver's contacts and a
/// tracker give are held against those of the finger, at the time at which they are known.
Study tracking_study(const StudyInput& input);

/// A row a solver.
TableSection tracking_table(const TrackingCondition& condition, const std::string& law);

/// The least sufficient frame rate: a row a solver, a column a speed; none where no speed was
/// measured at two frame rates or more.
std::vector<TableSection> frame_rate_tables(std::span<const TrackingCondition> conditions,
                                            const std::string& law);

/// The CSV file: a row for each condition and solver.
TableSection tracking_data(std::span<const TrackingCondition> conditions, const std::string& law);

using TrackingConditions = std::shared_ptr<const std::vector<TrackingCondition>>;
/// RMS distance and share of characters read back, by solver: over the speed for each frame rate,
/// and over the frame rate for speeds that were measured at some only.
StudyFigure tracking_sweep(const TrackingConditions& conditions, const std::string& law);
/// Written and tracked characters of the first condition, a column a solver.
StudyFigure tracking_gallery(const TrackingConditions& conditions, const std::string& law);

}  // namespace ertbench
