#include "bench/report/training_results.h"

#include <spdlog/spdlog.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/charts/training_chart.h"
#include "bench/plot/drawing.h"
#include "core/atomic_file.h"
#include "core/csv_field.h"
#include "core/errors.h"
#include "core/regular_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

std::optional<double> best_epoch(const nlohmann::json& parameters) {
  if (!parameters.is_object() || !parameters.contains("training")) return std::nullopt;
  const nlohmann::json& training = parameters.at("training");
  if (!training.is_object() || !training.contains("best_epoch")) return std::nullopt;
  const nlohmann::json& epoch = training.at("best_epoch");
  return epoch.is_number() ? std::optional(epoch.get<double>()) : std::nullopt;
}

/// The log of a training, which a plugin may have written.
std::string harmless_csv(const fs::path& file) {
  require_regular_file(file);
  const std::string text = contents_of(file);
  std::string out;
  for (const std::vector<std::string>& line : csv_lines(text)) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      out += (c > 0 ? "," : "") + csv_field(printable(line[c]));
    }
    out += "\n";
  }
  return out;
}

ReportFigure curves_of(const std::string& label, const fs::path& folder) {
  return {label, folder / (label + ".svg"),
          "losses and validation error; dots mark the epochs that were kept"};
}

}  // namespace

std::optional<ReportFigure> write_training_results(const std::string& label,
                                                   const std::vector<TrainingSource>& sources,
                                                   const fs::path& folder) {
  TrainingChart chart;
  chart.title = label;
  for (const TrainingSource& source : sources) {
    if (!fs::exists(source.log)) continue;
    fs::create_directories(folder);
    try {
      write_file_atomically(folder / (source.stem + ".csv"), harmless_csv(source.log));
      chart.runs.push_back(
          {source.title, read_training_curves(source.log), best_epoch(*source.parameters)});
    } catch (const InputError& error) {
      spdlog::warn("{}: {}", source.stem, error.what());
    }
  }
  if (chart.runs.empty()) return std::nullopt;
  const bool drawn =
      draw_or_say(folder / label, [&] { draw_training_chart(chart, folder / label); });
  ReportFigure figure = curves_of(label, folder);
  figure.drawn = drawn;
  return figure;
}

std::optional<ReportFigure> training_figure(const std::string& label, const fs::path& folder) {
  ReportFigure figure = curves_of(label, folder);
  return fs::exists(figure.svg) ? std::optional(figure) : std::nullopt;
}

}  // namespace ertbench
