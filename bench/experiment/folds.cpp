#include "bench/experiment/folds.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

/// Networks need two frames to learn from and one to be chosen by.
constexpr int fewest_presses = 5;

}  // namespace

std::uint64_t Folds::validation_count(std::uint64_t number) const {
  const auto share = static_cast<std::uint64_t>(std::lround(validation * double(number)));
  return std::clamp<std::uint64_t>(share, 1, number - 2);
}

DatasetSpec Folds::part(const char* name, const FoldPart& fold) const {
  DatasetSpec out = base;
  MeasuredFrames frames = *base.measured();
  frames.fold = fold;
  out.name = name;
  out.count = frames.rows().size();
  out.scenes = std::move(frames);
  return out;
}

DatasetSpec Folds::training(int fold, std::uint64_t number) const {
  return part("train", {count, fold, false, 0, number - validation_count(number), seed});
}

DatasetSpec Folds::validation_set(int fold, std::uint64_t number) const {
  DatasetSpec out =
      part("validation", {count, fold, false, number - validation_count(number), number, seed});
  out.noise = {};  // what is added to train with is not what is measured
  return out;
}

DatasetSpec Folds::test(int fold) const {
  DatasetSpec out = part("held-out", {count, fold, true, 0, 0, seed});
  out.noise = {};
  return out;
}

std::optional<Folds> read_folds(JsonObject& root, const Experiment& experiment) {
  if (!root.has("folds")) return std::nullopt;
  JsonObject object = root.object("folds");
  const DatasetSpec* train = experiment.training ? &*experiment.training : nullptr;
  if (train == nullptr || train->measured() == nullptr || !train->measured()->truth.places) {
    root.fail("folds",
              "divide measured frames with known places; let /datasets/train name such a \"file\"");
  }
  Folds folds;
  folds.base = *train;
  MeasuredFrames frames = *train->measured();
  frames.fold.reset();
  if (object.has("rows")) {
    const std::vector<double> ends = object.numbers("rows", 2, {0, 1e9});
    frames.first = static_cast<std::uint64_t>(ends[0]);
    frames.last = static_cast<std::uint64_t>(ends[1]);
    const DatasetSpec* last = nullptr;
    for (const DatasetSpec* spec : experiment.datasets()) {
      const MeasuredFrames* other = spec->measured();
      if (other && other->checksum == frames.checksum &&
          (!last || other->last > last->measured()->last)) {
        last = spec;
      }
    }
    if (frames.first >= frames.last || frames.last > last->measured()->last) {
      object.fail("rows",
                  "must be [first, last) of rows that the experiment's datasets of that "
                  "file reach, up to " +
                      std::to_string(last->measured()->last));
    }
  }
  const std::uint64_t rows = frames.last - frames.first;
  folds.base.scenes = std::move(frames);
  folds.count = object.integer_or("count", folds.count, 2, 100);
  if (static_cast<std::uint64_t>(folds.count) > rows) {
    object.fail("count", "must be at most the number of rows, " + std::to_string(rows));
  }
  const auto shares = static_cast<std::uint64_t>(folds.count);
  const std::uint64_t most = rows - (rows + shares - 1) / shares;  // that every fold's rest has
  if (object.has("presses")) {
    const auto limit = static_cast<int>(std::min<std::uint64_t>(most, 1000000));
    for (const int number : object.integers("presses", 1, 20, {fewest_presses, limit})) {
      folds.presses.push_back(static_cast<std::uint64_t>(number));
    }
    std::sort(folds.presses.begin(), folds.presses.end());
    folds.presses.erase(std::unique(folds.presses.begin(), folds.presses.end()),
                        folds.presses.end());
  } else if (most < fewest_presses) {
    object.fail("count", "leaves fewer than 5 presses to learn from");
  } else {
    folds.presses = {most};
  }
  folds.validation = object.number_or("validation", folds.validation, {0, 0.9});
  folds.seed = static_cast<std::uint64_t>(object.integer_or("seed", 1, 0, 2147483647));
  object.finish();
  return folds;
}

nlohmann::json to_json(const Folds& folds) {
  return {{"base", to_json(folds.base)},
          {"count", folds.count},
          {"presses", folds.presses},
          {"validation", folds.validation},
          {"seed", folds.seed}};
}

}  // namespace ertbench
