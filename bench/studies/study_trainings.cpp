#include "bench/studies/study_trainings.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/report/report.h"
#include "bench/studies/study_text.h"
#include "core/moments.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::vector<double> defined(const std::vector<std::optional<double>>& values) {
  std::vector<double> out;
  for (const std::optional<double>& value : values) {
    if (value) out.push_back(*value);
  }
  return out;
}

json json_of(const std::optional<double>& value) { return value ? json(*value) : json(); }

std::size_t most_trainings(const std::vector<HeadlineSpread>& spread) {
  std::size_t most = 0;
  for (const HeadlineSpread& one : spread) most = std::max(most, one.values.size());
  return most;
}

TableSection table_of(const std::vector<HeadlineSpread>& spread) {
  TableSection table;
  table.columns = {{"solver", Align::left}, {"number", Align::left}, {"mean"}, {"deviation"}};
  const std::size_t trainings = most_trainings(spread);
  for (std::size_t t = 0; t < trainings; ++t) {
    table.columns.push_back("training " + std::to_string(t + 1));
  }
  std::string before;
  for (const HeadlineSpread& one : spread) {
    std::vector<Cell> row = {one.label == before ? "" : one.label, one.what,
                             number_cell(one.mean(), one.decimals),
                             number_cell(one.deviation(), one.decimals)};
    before = one.label;
    for (std::size_t t = 0; t < trainings; ++t) {
      row.push_back(t < one.values.size() ? number_cell(one.values[t], one.decimals) : Cell());
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// A row a training, for programs.
TableSection rows_of(const std::vector<HeadlineSpread>& spread) {
  TableSection rows;
  rows.columns = {{"solver", Align::left}, {"what", Align::left}, {"training"}, {"value"}};
  for (const HeadlineSpread& one : spread) {
    for (std::size_t t = 0; t < one.values.size(); ++t) {
      rows.rows.push_back({one.label, one.what, std::to_string(t + 1), exact_cell(one.values[t])});
    }
  }
  return rows;
}

}  // namespace

std::optional<double> HeadlineSpread::mean() const {
  const std::vector<double> found = defined(values);
  return found.empty() ? std::nullopt : std::optional(ertbench::mean(found));
}

std::optional<double> HeadlineSpread::deviation() const {
  const std::vector<double> found = defined(values);
  return found.size() < 2 ? std::nullopt : std::optional(sample_deviation(found));
}

std::vector<HeadlineSpread> spread_of(std::span<const std::vector<Headline>> of_trainings) {
  std::vector<HeadlineSpread> out;
  for (const Headline& first : of_trainings.front()) {
    HeadlineSpread spread{first.label, first.what, first.decimals, {first.value}};
    for (const std::vector<Headline>& training : of_trainings.subspan(1)) {
      const auto found =
          std::find_if(training.begin(), training.end(), [&](const Headline& headline) {
            return headline.label == first.label && headline.what == first.what;
          });
      if (found != training.end()) spread.values.push_back(found->value);
    }
    if (spread.values.size() > 1) out.push_back(std::move(spread));
  }
  // A study tells set by set; here a solver's numbers stand together.
  std::vector<std::string> labels;
  for (const HeadlineSpread& one : out) {
    if (std::find(labels.begin(), labels.end(), one.label) == labels.end()) {
      labels.push_back(one.label);
    }
  }
  const auto place = [&](const HeadlineSpread& one) {
    return std::find(labels.begin(), labels.end(), one.label) - labels.begin();
  };
  std::stable_sort(out.begin(), out.end(), [&](const HeadlineSpread& a, const HeadlineSpread& b) {
    return place(a) < place(b);
  });
  return out;
}

json StudyTrainings::summary() const {
  json out = first_->summary();
  json& trainings = out["trainings"] = json::array();
  for (const HeadlineSpread& one : spread_) {
    json values = json::array();
    for (const std::optional<double>& value : one.values) values.push_back(json_of(value));
    trainings.push_back({{"solver", one.label},
                         {"what", one.what},
                         {"values", values},
                         {"mean", json_of(one.mean())},
                         {"deviation", json_of(one.deviation())}});
  }
  return out;
}

std::vector<ReportSection> StudyTrainings::report(const std::string& title,
                                                  const std::filesystem::path& folder) const {
  std::vector<ReportSection> sections = first_->report(title, folder);
  ReportSection section;
  section.title = name_ + ": what another training changes";
  section.text =
      "The study's own tables and figures are of the first training of each solver. Here are its "
      "headline numbers of all trainings, which differ by their seed alone: their mean, their "
      "sample standard deviation, and each. Two solvers whose numbers differ by less than a few "
      "deviations are told apart by the trainings' luck.";
  section.tables = {table_of(spread_)};
  section.collapsed = true;
  write_study_tables({title + ", by training", section.text, section.tables, {}, {}},
                     rows_of(spread_), folder, name_ + "_trainings");
  sections.push_back(std::move(section));
  return sections;
}

}  // namespace ertbench
