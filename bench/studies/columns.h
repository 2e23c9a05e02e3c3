#pragma once

#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/record/experiment_results.h"
#include "bench/studies/error_statistics.h"
#include "bench/table/table.h"

namespace ertbench {

/// One number that a study tells of each of its rows, in all outputs of the study:
///
///     using Rule = PlaceErrors::Rule;
///     const StudyColumns<Rule> columns = {
///         StudyColumn<Rule>::estimate("mean_mm", &Rule::mean, 2).table("mean"),
///         StudyColumn<Rule>::number("worst_mm", &Rule::worst, 1).table("worst")};
///
/// It stands under its key in summary.json and in the CSV file, in the tables under a title if it
/// is given one, and among the headlines if it is given one.
template <class Row>
class StudyColumn {
 public:
  template <class Value>
  using Get = std::function<Value(const Row&)>;
  using Json = nlohmann::json;

  static StudyColumn words(const std::string& key, const Get<std::string>& get) {
    StudyColumn out(key, [get](const Row& row) { return Cell(get(row)); });
    out.align_ = Align::left;
    out.json_ = [get](const Row& row) { return Json(get(row)); };
    return out;
  }
  static StudyColumn count(const std::string& key, const Get<std::optional<std::size_t>>& get) {
    StudyColumn out(key, [get](const Row& row) {
      const auto value = get(row);
      return value ? Cell(std::to_string(*value)) : Cell();
    });
    out.json_ = [get](const Row& row) {
      const auto value = get(row);
      return value ? Json(*value) : Json();
    };
    return out;
  }
  /// `decimals` in the tables; files have all digits.
  static StudyColumn number(const std::string& key, const Get<std::optional<double>>& get,
                            int decimals) {
    StudyColumn out(key, [get](const Row& row) { return exact_cell(get(row)); });
    out.shown_ = [get, decimals](const Row& row) { return number_cell(get(row), decimals); };
    out.json_ = [get](const Row& row) { return to_json(get(row)); };
    out.number_ = get;
    return out;
  }
  /// Three columns of the CSV file: KEY, KEY_low and KEY_high. Tables show `factor` times it.
  static StudyColumn estimate(const std::string& key, const Get<std::optional<Estimate>>& get,
                              int decimals, double factor = 1) {
    StudyColumn out(key, {});
    out.estimate_ = get;
    out.shown_ = [get, decimals, factor](const Row& row) {
      return estimate_cell(scaled(get(row), factor), decimals);
    };
    out.json_ = [get](const Row& row) { return to_json(get(row)); };
    out.number_ = [get](const Row& row) { return value_of(get(row)); };
    return out;
  }
  /// A column of the tables alone.
  static StudyColumn cell(const std::string& title, const Get<Cell>& get) {
    StudyColumn out("", get);
    return out.table(title);
  }

  /// `part`: of a wide table (Column::part).
  StudyColumn& table(const std::string& title, int part = 0) {
    title_ = Column(title, align_, part);
    return *this;
  }
  /// In the tables a cell of its own making.
  StudyColumn& shown(const Get<Cell>& get) {
    shown_ = get;
    return *this;
  }
  /// In summary.json a value of its own making.
  StudyColumn& json(const Get<Json>& get) {
    json_ = get;
    return *this;
  }
  /// Another name in the CSV file than in summary.json; empty: not in the file.
  StudyColumn& data(const std::string& name) {
    name_ = name;
    return *this;
  }
  /// Not in summary.json.
  StudyColumn& data_only() {
    key_.clear();
    return *this;
  }
  /// `what` with condition and unit (Headline::what); a row for which it is empty has none.
  StudyColumn& headline(const Get<std::string>& what, int decimals) {
    what_ = what;
    headline_decimals_ = decimals;
    return *this;
  }

 private:
  StudyColumn(const std::string& key, const Get<Cell>& exact)
      : key_(key), name_(key), exact_(exact), shown_(exact) {}

  std::string key_;
  std::string name_;
  Align align_ = Align::right;
  std::optional<Column> title_;
  Get<Cell> exact_;
  Get<std::optional<Estimate>> estimate_;
  Get<Cell> shown_;
  Get<Json> json_;
  Get<std::optional<double>> number_;
  Get<std::string> what_;
  int headline_decimals_ = 2;

  template <class>
  friend class StudyColumns;
};

/// Adds the row that says why there is nothing of a solver; false and nothing without a failure.
inline bool add_failed(const std::string& label, const std::string& failure, TableSection& table) {
  if (failure.empty()) return false;
  table.rows.push_back({label, failure});
  table.rows.back().resize(table.columns.size());
  return true;
}

/// The columns of a study, in their order.
template <class Row>
class StudyColumns {
 public:
  StudyColumns(std::initializer_list<StudyColumn<Row>> columns) : columns_(columns) {}

  void add(const StudyColumn<Row>& column) { columns_.push_back(column); }

  /// The columns of a table, behind `first`.
  std::vector<Column> titles(std::vector<Column> first) const {
    for (const auto& column : columns_) {
      if (column.title_) first.push_back(*column.title_);
    }
    return first;
  }
  /// A row of it.
  std::vector<Cell> cells(std::vector<Cell> first, const Row& row) const {
    for (const auto& column : columns_) {
      if (column.title_) first.push_back(column.shown_(row));
    }
    return first;
  }
  /// The columns of a CSV file, behind `first`.
  std::vector<Column> names(std::vector<Column> first) const {
    for (const auto& column : columns_) {
      if (column.name_.empty()) continue;
      first.emplace_back(column.name_, column.align_);
      if (!column.estimate_) continue;
      for (const char* end : {"_low", "_high"}) first.emplace_back(column.name_ + end);
    }
    return first;
  }
  /// A row of it.
  std::vector<Cell> data(std::vector<Cell> first, const Row& row) const {
    for (const auto& column : columns_) {
      if (column.name_.empty()) continue;
      if (!column.estimate_) {
        first.push_back(column.exact_(row));
        continue;
      }
      for (const Cell& cell : exact_cells(column.estimate_(row))) first.push_back(cell);
    }
    return first;
  }
  /// An object of summary.json.
  nlohmann::json json(const Row& row) const {
    nlohmann::json out = nlohmann::json::object();
    for (const auto& column : columns_) {
      if (!column.key_.empty()) out[column.key_] = column.json_(row);
    }
    return out;
  }
  void add_headlines(const std::string& label, const Row& row, std::vector<Headline>& out) const {
    for (const auto& column : columns_) {
      const std::string what = column.what_ ? column.what_(row) : "";
      if (what.empty()) continue;
      out.push_back({label, what, column.headline_decimals_, column.number_(row)});
    }
  }

 private:
  std::vector<StudyColumn<Row>> columns_;
};

}  // namespace ertbench
