#include "bench/record/folds_record.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/record/cache.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Raised whenever the same presses would be read otherwise, or the layout changes.
constexpr int folds_schema = 1;

json press_json(const HeldOutPress& press) {
  json out = {press.place_mm.x(), press.place_mm.y(), press.strength, nullptr, nullptr, 0};
  if (press.found_mm) {
    out[3] = press.found_mm->x();
    out[4] = press.found_mm->y();
    out[5] = press.found_strength;
  }
  return out;
}

HeldOutPress press_from(const json& values) {
  HeldOutPress out;
  out.place_mm = {values.at(0).get<double>(), values.at(1).get<double>()};
  out.strength = values.at(2).get<double>();
  if (!values.at(3).is_null()) {
    out.found_mm = Eigen::Vector2d(values.at(3).get<double>(), values.at(4).get<double>());
  }
  out.found_strength = values.at(5).get<double>();
  return out;
}

}  // namespace

std::string fold_key(const FitRecipe& recipe, const Folds& folds, int fold, const json& contacts) {
  FitRecipe own = recipe;
  own.training.reset();
  own.validation.reset();
  const json key = {{"schema", folds_schema},
                    {"label", recipe.entry.label},
                    {"entry", recipe.entry.spec.text()},
                    {"solver", Cache::fitted_solver_key(own).dump()},
                    {"folds", to_json(folds)},
                    {"contacts", contacts},
                    {"fold", fold}};
  return hash_of(key.dump());
}

json to_json(const FoldRecord& record) {
  json out = {{"schema", folds_schema}, {"runs", json::array()}};
  for (const FoldRun& run : record) {
    json one = {{"presses", run.presses},
                {"message", run.message},
                {"fit_s", run.fit_s},
                {"held_out", json::array()}};
    for (const HeldOutPress& press : run.held_out) one["held_out"].push_back(press_json(press));
    out["runs"].push_back(std::move(one));
  }
  return out;
}

FoldRecord fold_record_from_json(const json& object) {
  FoldRecord record;
  for (const json& one : object.at("runs")) {
    FoldRun& run = record.emplace_back();
    run.presses = one.at("presses").get<std::uint64_t>();
    run.message = one.at("message").get<std::string>();
    run.fit_s = one.at("fit_s").get<double>();
    for (const json& press : one.at("held_out")) run.held_out.push_back(press_from(press));
  }
  return record;
}

}  // namespace ertbench
