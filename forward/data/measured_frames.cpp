#include "forward/data/measured_frames.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/process.h"
#include "core/random.h"
#include "core/text.h"
#include "forward/data/measured_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Of the sheet's inner radius: the size of a contact of which only the place is known.
constexpr double default_radius = 0.15;

/// What the file said of itself: `{"size", "images", "places", "contacts"}`, or `{"refused"}`.
json look_here(const MeasuredFrames& frames, const Sensor& sensor) {
  const MeasuredFile file(frames.file, sensor);
  json out = {{"size", file.size()},
              {"images", file.truth().images},
              {"places", file.truth().places},
              {"contacts", file.contacts()}};
  MeasuredFrames known = frames;
  if (known.last == 0) known.last = file.size();
  if (known.last > file.size()) return out;  // said with the place in the experiment
  std::vector<std::uint64_t> rows(known.last - known.first);
  std::iota(rows.begin(), rows.end(), known.first);
  known.truth = file.truth();
  file.read(known, sensor, rows);
  return out;
}

/// The same in a child, as the HDF5 library does not survive every damaged file.
json look(const MeasuredFrames& frames, const Sensor& sensor) {
  constexpr double time_limit_s = 600;
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        json said;
        try {
          said = look_here(frames, sensor);
        } catch (const InputError& wrong) {
          said = {{"refused", printable(wrong.what())}};
        }
        send(said.dump());
      },
      {time_limit_s, machine_memory_bytes() / 2});
  if (!outcome.finished || outcome.messages.empty()) {
    throw InputError(frames.file.string() +
                     ": is damaged: the HDF5 library cannot get through it; write it again");
  }
  json said = json::parse(outcome.messages.back());
  if (said.contains("refused")) throw InputError(said.at("refused").get<std::string>());
  return said;
}

/// Finds the file and what it holds.
void look_at(JsonObject& object, const Sensor& sensor, const fs::path& folder, bool rows_given,
             MeasuredFrames& frames) {
  frames.file = object.text("file");
  if (frames.file.is_relative()) frames.file = folder / frames.file;
  frames.name = frames.file.filename().string();
  if (!fs::is_regular_file(frames.file)) {
    object.fail("file", "there is no file " + printable_path(frames.file.string()) +
                            "; a relative path begins at the experiment's folder");
  }
  const std::string checksum = hash_of_file(frames.file);
  if (object.has("checksum") && object.text("checksum") != checksum) {
    object.fail("checksum", "the file has another one, " + checksum +
                                "; leave it out, or name the file that was meant");
  }
  frames.checksum = checksum;
  json said;
  try {
    said = look(frames, sensor);
  } catch (const InputError& wrong) {
    object.fail("file", wrong.what());
  }
  const auto size = said.at("size").get<std::uint64_t>();
  if (!rows_given) frames.last = size;
  if (frames.last > size) {
    object.fail("rows", "must be rows [first, last) of the " + std::to_string(size) +
                            " in the file, got " + std::to_string(frames.first) + " to " +
                            std::to_string(frames.last));
  }
  frames.truth = {said.at("images").get<bool>(), said.at("places").get<bool>()};
  frames.contacts = said.at("contacts").get<std::uint64_t>();
}

FoldPart fold_from_json(JsonObject object, std::uint64_t rows) {
  FoldPart fold;
  fold.count = object.integer_or("count", fold.count, 2, 1000);
  if (static_cast<std::uint64_t>(fold.count) > rows) {
    object.fail("count", "must be at most the number of rows, " + std::to_string(rows));
  }
  fold.number = object.integer("number", 0, fold.count - 1);
  fold.held_out = object.choice("part", {"held-out", "rest"}) == "held-out";
  fold.seed = static_cast<std::uint64_t>(object.integer_or("seed", 1, 0, 2147483647));
  if (!fold.held_out) {
    const auto count = static_cast<std::uint64_t>(fold.count);
    const auto number = static_cast<std::uint64_t>(fold.number);
    fold.to = rows - (rows * (number + 1) / count - rows * number / count);
    if (object.has("slice")) {
      const std::vector<double> ends =
          object.numbers("slice", 2, {0, static_cast<double>(fold.to)});
      fold.from = static_cast<std::uint64_t>(ends[0]);
      fold.to = static_cast<std::uint64_t>(ends[1]);
      if (fold.from >= fold.to) object.fail("slice", "must be [from, to) with from < to");
    }
  }
  object.finish();
  return fold;
}

void read_contact(JsonObject object, const Sensor& sensor, MeasuredFrames& frames) {
  const double unit = sensor.sheet->unit_mm();
  frames.radius_mm = object.number_or("radius_mm", frames.radius_mm,
                                      {1e-6 * unit, sensor.sheet->radius() * unit, false, "mm"});
  frames.conductivity_ratio = object.number_or("conductivity_ratio", frames.conductivity_ratio,
                                               {conductivity_ratios[0], conductivity_ratios[1]});
  if (object.has("strength")) {
    JsonObject strength = object.object("strength");
    frames.strength_of = strength.text("dataset");
    frames.full_strength = strength.number("full", Range::positive());
    strength.finish();
  }
  object.finish();
}

}  // namespace

std::vector<std::uint64_t> MeasuredFrames::rows() const {
  std::vector<std::uint64_t> all(last - first);
  std::iota(all.begin(), all.end(), first);
  if (!fold) return all;
  RandomStream random(fold->seed, key_of("folds"), 0, Purpose::scene);
  for (std::size_t i = all.size(); i > 1; --i) {  // Fisher-Yates
    std::swap(all[i - 1],
              all[static_cast<std::size_t>(random.integer(0, static_cast<int>(i) - 1))]);
  }
  const auto at = [&](int number) {
    return all.begin() + static_cast<std::ptrdiff_t>(all.size() * static_cast<std::size_t>(number) /
                                                     static_cast<std::size_t>(fold->count));
  };
  const auto begin = at(fold->number);
  const auto end = at(fold->number + 1);
  if (fold->held_out) return {begin, end};
  // The rest begins behind the share, so that the first rows of two folds' rests are not the same.
  std::vector<std::uint64_t> rest(end, all.end());
  rest.insert(rest.end(), all.begin(), begin);
  return {rest.begin() + static_cast<std::ptrdiff_t>(fold->from),
          rest.begin() + static_cast<std::ptrdiff_t>(fold->to)};
}

MeasuredFrames measured_frames_from_json(JsonObject& object, const Sensor& sensor,
                                         const std::optional<fs::path>& folder) {
  MeasuredFrames frames;
  const bool rows_given = object.has("rows") && !object.raw("rows").is_null();
  if (rows_given) {
    const std::vector<double> ends = object.numbers("rows", 2, {0, 1e9});
    frames.first = static_cast<std::uint64_t>(ends[0]);
    frames.last = static_cast<std::uint64_t>(ends[1]);
    if (ends[0] != static_cast<double>(frames.first) ||
        ends[1] != static_cast<double>(frames.last) || frames.first >= frames.last) {
      object.fail("rows", "must be [first, last), whole numbers with first < last");
    }
  }
  frames.scale = object.number_or("scale", frames.scale, {1e-12, 1e12, false, "V"});
  frames.radius_mm = default_radius * sensor.sheet->inner_radius() * sensor.sheet->unit_mm();
  if (object.has("contact")) read_contact(object.object("contact"), sensor, frames);
  if (folder) {
    look_at(object, sensor, *folder, rows_given, frames);
  } else {
    frames.name = object.text("file");
    frames.checksum = object.text("checksum");
    JsonObject holds = object.object("holds");
    frames.truth = {holds.boolean_or("images", false), holds.boolean_or("places", false)};
    frames.contacts = static_cast<std::uint64_t>(holds.integer("contacts", 1, 1000));
    holds.finish();
  }
  if (object.has("fold")) {
    frames.fold = fold_from_json(object.object("fold"), frames.last - frames.first);
  }
  return frames;
}

void add_to(json& out, const MeasuredFrames& frames) {
  out["file"] = frames.name;
  out["checksum"] = frames.checksum;
  out["rows"] = {frames.first, frames.last};
  out["scale"] = frames.scale;
  out["contact"] = {{"radius_mm", frames.radius_mm},
                    {"conductivity_ratio", frames.conductivity_ratio}};
  if (!frames.strength_of.empty()) {
    out["contact"]["strength"] = {{"dataset", frames.strength_of}, {"full", frames.full_strength}};
  }
  if (const auto& fold = frames.fold) {
    out["fold"] = {{"count", fold->count},
                   {"number", fold->number},
                   {"part", fold->held_out ? "held-out" : "rest"},
                   {"seed", fold->seed}};
    if (!fold->held_out) out["fold"]["slice"] = {fold->from, fold->to};
  }
  out["holds"] = {{"images", frames.truth.images},
                  {"places", frames.truth.places},
                  {"contacts", frames.contacts}};
}

}  // namespace ertbench
