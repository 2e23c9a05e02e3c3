#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/studies/study.h"
#include "bench/studies/targets_scores.h"

namespace ertbench {

/// Contacts that a solver detected in the study's frames.
struct TargetReadings {
  std::string label;
  std::string failure;                     ///< why some are missing; else empty
  std::vector<const FrameReading*> found;  ///< [frames]; null where it did not get that far
};

/// One solver's part of the study.
struct TargetSolver {
  std::string label;
  std::string failure;                ///< why there is nothing, or not all; else empty
  std::map<int, TargetCount> counts;  ///< by number of true contacts
  TargetGaps gaps;
  struct Found {
    std::vector<ContactReading> contacts;
    TargetMatch match;
  };
  std::vector<std::optional<Found>> gallery;  ///< [TargetResults::gallery]
};

struct TargetResults {
  std::vector<int> numbers;  ///< of true contacts that are compared, ascending
  std::vector<TargetSolver> solvers;
  std::vector<TargetFrame> gallery;  ///< the first frame of each number of contacts, ascending
};

/// Scores of each solver's contacts in the frames.
TargetResults target_results(std::span<const TargetFrame> frames,
                             std::span<const TargetReadings> readings,
                             const ContactDistances& distances);

/// Circumstances that tables and figures name.
struct TargetCircumstances {
  std::string name;        ///< of the study and its files
  std::string conditions;  ///< "falling law, 50 dB absolute"
  ContactDistances distances;
  std::shared_ptr<const Sheet> sheet;
};

/// D.3: how many touch? Still touches, one or several at a time: which of them are detected, how
/// many false positives there are, and how close two may come before they are one.
Study targets_study(const StudyInput& input);
Study study_of_targets(const TargetCircumstances& circumstances, const TargetResults& results);

/// A row for each number of contacts and solver.
TableSection targets_count_table(const TargetCircumstances& circumstances,
                                 const TargetResults& results);
/// A row for each solver: the resolvable gap, and the share resolved by gap.
TableSection targets_gap_table(const TargetCircumstances& circumstances,
                               const TargetResults& results);
/// CSV files with all digits and intervals: a row for each solver, number of contacts and metric,
/// and a row for each solver and bin of gaps with one for the resolvable gap.
TableSection targets_count_data(const TargetResults& results);
TableSection targets_gap_data(const TargetResults& results);

/// Recall and false positives against the number of contacts, share resolved against the gap.
StudyFigure targets_chart(const TargetCircumstances& circumstances,
                          std::shared_ptr<const TargetResults> results);
/// The paper's figure D4: a row for each number of contacts, a column for each solver; the true
/// footprints and the places that were found.
StudyFigure targets_gallery(const TargetCircumstances& circumstances,
                            std::shared_ptr<const TargetResults> results);

}  // namespace ertbench
