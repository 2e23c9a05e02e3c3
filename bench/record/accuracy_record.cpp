#include "bench/record/accuracy_record.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/record/cache.h"
#include "bench/record/frame_reading_record.h"
#include "bench/record/record_file.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

using nlohmann::json;

ScoredSet scored_set(const json& row, const json& frames, const std::string& source) {
  ScoredSet set;
  set.row = result_row_from_json(JsonObject(row, source, "/rows"));
  for (const json& status : frames.at("status")) {
    set.statuses.push_back(static_cast<FrameStatus>(status.get<int>()));
  }
  set.frames.resize(set.statuses.size());
  for (const Metric metric : kMetrics) {
    if (!frames.contains(name_of(metric))) continue;  // written before there was this metric
    const json& values = frames.at(name_of(metric));
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      if (!values.at(i).is_null()) set.frames[i][metric] = values[i].get<double>();
    }
  }
  if (frames.contains("readings")) {
    set.readings = frame_readings_from_json(frames.at("readings"));
    if (set.readings.size() != set.frames.size()) {
      throw std::invalid_argument("a reading for each frame is wanted");
    }
  }
  return set;
}

Images images_from(const json& rows, int pixels) {
  Images images(static_cast<Eigen::Index>(rows.size()), pixels);
  for (Eigen::Index i = 0; i < images.rows(); ++i) {
    for (Eigen::Index p = 0; p < pixels; ++p) {
      const json& value = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(p));
      images(i, p) = value.is_null() ? std::nan("") : value.get<double>();
    }
  }
  return images;
}

}  // namespace

std::string accuracy_key(const FitRecipe& recipe, std::span<const DatasetSpec> tests,
                         const AccuracyContent& content) {
  json key = {{"schema", record_schema},
              {"metrics", metrics_version},
              {"label", recipe.entry.label},
              {"entry", recipe.entry.spec.text()},
              {"solver", Cache::fitted_solver_key(recipe).dump()},
              {"scored", names_of(kMetrics)},  // a record without one of them is made again
              {"figure", content.figure_scenes}};
  for (const DatasetSpec& test : tests) key["tests"].push_back(to_json(test));
  if (content.validation) key["validation"] = true;
  if (content.contacts != ContactSettings{}) key["contacts"] = to_json(content.contacts);
  if (content.keep_contacts) key["keep_contacts"] = true;
  if (content.keep_explained) key["keep_explained"] = true;
  return hash_of(key.dump());
}

AccuracyRecord accuracy_record_from_json(const json& record, bool validation, int pixels,
                                         const std::string& source) {
  AccuracyRecord out;
  for (const json& row : record.at("rows")) {
    const json& frames = record.at("frames").at(row.at("dataset").get<std::string>());
    out.sets.push_back(scored_set(row, frames, source));
  }
  if (validation) {
    out.validation = std::move(out.sets.back());
    out.sets.pop_back();
  }
  out.figure_images = images_from(record.at("figure_images"), pixels);
  return out;
}

}  // namespace ertbench
