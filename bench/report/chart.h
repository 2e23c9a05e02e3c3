#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment_charts.h"
#include "bench/plot/palette.h"
#include "bench/record/result_row.h"
#include "bench/table/table.h"

namespace ertbench {

/// A chart that an experiment asks for. A type of chart is a class derived from this one, with a
/// `type` as experiment files spell it and a constructor that reads its own keys from a
/// ChartRequest:
///
///     class DepthChart : public Chart {
///      public:
///       static constexpr const char* type = "depth";
///       explicit DepthChart(const ChartRequest& request);
///       void draw(...) const override;
///       std::string caption() const override;
///     };
///
/// and a line in chart_types.cpp. Nothing else asks for the type of a chart.
class Chart {
 public:
  explicit Chart(ChartPlace place) : place_(std::move(place)) {}
  virtual ~Chart() = default;
  Chart(const Chart&) = delete;
  Chart& operator=(const Chart&) = delete;

  const std::string& name() const { return place_.name; }
  const std::string& dataset() const { return place_.dataset; }

  /// Draws `folder`/`name`.svg and .png and writes the files that belong to them. A row that is
  /// missing leaves its place with "not run". `title` is the experiment's. Throws InputError where
  /// gnuplot is missing or a file cannot be written.
  virtual void draw(std::span<const ResultRow> rows, const std::string& title,
                    const std::filesystem::path& folder) const = 0;

  /// Text of what the figure shows, behind its name in the report.
  virtual std::string caption() const = 0;

  /// The title of its own section of the report; empty where it stands among the other charts, and
  /// then it has neither notes nor tables.
  virtual std::string section() const { return ""; }
  /// The tables of that section, with a text on how to read them.
  virtual Table table(std::span<const ResultRow> /*rows*/) const { return {}; }

  /// Puts what other programs may want to read into summary.json, under a key of its type's and its
  /// name.
  virtual void summarise(std::span<const ResultRow> /*rows*/, nlohmann::json& /*summary*/) const {}

 protected:
  /// The row of that label and of the chart's dataset; null where there is none.
  const ResultRow* find_row(std::span<const ResultRow> rows, const std::string& label) const {
    return ertbench::find_row(rows, label, dataset());
  }

 private:
  ChartPlace place_;
};

/// "" for a row where all is well, else "failed", "diverged", ...; "not run" for null.
std::string chart_status(const ResultRow* row);

/// How methods are told from each other, in colour, without it and in grey. A method of ertbench's
/// looks the same in every chart, whatever stands beside it; other labels take what is left.
class MethodStyles {
 public:
  /// `labels`: all in one chart. A label that is a method's name, or begins with it and a blank
  /// ("contacts disc"), has that method's hue; several of one method differ in shade, shape and
  /// dash.
  explicit MethodStyles(std::span<const std::string> labels);

  Colour colour(std::size_t label) const;
  LineStyle line(std::size_t label, double width = 1.3) const;
  /// Filled or hollow, so that more methods than there are shapes can be told apart in grey.
  MarkStyle mark(std::size_t label, double size = 0.75) const;
  /// Where the difference of the two means something.
  MarkStyle filled_mark(std::size_t label, double size = 0.75) const;
  MarkStyle hollow_mark(std::size_t label, double size = 0.75) const;

 private:
  struct Style {
    std::size_t place = 0;    ///< of the method, among all that can be told apart
    std::size_t variant = 0;  ///< of the labels of that method

    std::size_t shape() const { return place + variant; }
  };
  std::vector<Style> styles_;
};

/// Returns the styles of things that have labels, in their order.
template <class Labelled>
MethodStyles styles_of(const std::vector<Labelled>& all) {
  std::vector<std::string> labels;
  for (const Labelled& one : all) labels.push_back(one.label);
  return MethodStyles(labels);
}

}  // namespace ertbench
