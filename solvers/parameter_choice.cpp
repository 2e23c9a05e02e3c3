#include "solvers/parameter_choice.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/process.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"

namespace ertbench {

Tunable read_tunable(JsonObject& object, std::string_view key, Range range, bool whole) {
  const std::string source = object.source().empty() ? "" : object.source() + ": ";
  Tunable tunable{std::nullopt, source + object.path_of(key)};
  if (!object.has(key)) return tunable;
  const nlohmann::json& value = object.raw(key);
  if (value.is_string() && value.get_ref<const std::string&>() == "auto") return tunable;
  const bool usable = value.is_number() && range.contains(value.get<double>()) &&
                      (!whole || value.get<double>() == std::floor(value.get<double>()));
  if (!usable) {
    object.fail(key, (whole ? "must be a whole number, " : "") + range.text() +
                         " or \"auto\", got " + json_shown(value));
  }
  tunable.value = value.get<double>();
  return tunable;
}

void Tunable::require_chosen() const {
  if (automatic()) throw InputError(place + ": must be a number in a fit; fit the solver again");
}

Tunable read_weight(JsonObject& object, std::string_view key) {
  constexpr Range weights{1e-20, 1e20};
  Tunable tunable = read_tunable(object, key, Range::positive());
  if (tunable.value && !weights.contains(*tunable.value)) {
    object.fail(key, weights.text() + " or \"auto\", got " + number_text(*tunable.value));
  }
  return tunable;
}

namespace {

constexpr const char* rule =
    "least mean relative error of the conductivity change over validation frames with a contact";
constexpr std::size_t block = 8;  ///< frames that a thread takes at a time

}  // namespace

ValidationFrames read_validation_frames(const FitInput& input, const std::string& place) {
  if (!input.validation) {
    throw InputError(place + ": \"auto\" needs a validation set; give a number");
  }
  const DatasetFile& set = *input.validation;
  if (set.sensor() != input.sensor) {
    throw InputError(place + ": the validation set " + set.path().string() +
                     " is of another sensor; generate it for this one");
  }
  ValidationFrames frames{Frames(choice_frames, input.sensor.channels()),
                          Images(choice_frames, input.sensor.pixels())};
  Eigen::Index found = 0;
  for (std::uint64_t first = 0; first < set.size() && found < choice_frames;
       first += choice_frames) {
    const std::uint64_t count = std::min<std::uint64_t>(choice_frames, set.size() - first);
    const Images truths = set.conductivity(first, count).array() - input.sensor.background;
    const Frames voltages = set.voltages(first, count);
    for (Eigen::Index f = 0; f < truths.rows() && found < choice_frames; ++f) {
      // Rounding in the file's conductivities is no contact.
      if (truths.row(f).cwiseAbs().maxCoeff() <= 1e-12 * input.sensor.background) continue;
      frames.truths.row(found) = truths.row(f);
      frames.changes.row(found) = voltages.row(f) - set.reference_voltages().transpose();
      ++found;
    }
  }
  if (found == 0) {
    throw InputError(place + ": \"auto\" needs a validation set with contacts; " +
                     set.path().string() + " has none");
  }
  frames.changes.conservativeResize(found, Eigen::NoChange);
  frames.truths.conservativeResize(found, Eigen::NoChange);
  return frames;
}

double mean_relative_error(const Images& images, std::span<const FrameReport> reports,
                           const Images& truths) {
  double sum = 0;
  for (Eigen::Index f = 0; f < truths.rows(); ++f) {
    const bool undefined = reports[static_cast<std::size_t>(f)].status == FrameStatus::undefined ||
                           !images.row(f).allFinite();
    sum += undefined ? 1 : (images.row(f) - truths.row(f)).norm() / truths.row(f).norm();
  }
  return sum / static_cast<double>(truths.rows());
}

double mean_relative_error(const Solver& solver, const ValidationFrames& frames, int threads) {
  const Eigen::Index count = frames.changes.rows();
  Images images(count, frames.truths.cols());
  std::vector<FrameReport> reports(static_cast<std::size_t>(count));
  parallel_for(reports.size(), block, threads, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Eigen::Index>(begin);
    const auto size = static_cast<Eigen::Index>(end - begin);
    solver.reconstruct(frames.changes.middleRows(first, size), images.middleRows(first, size),
                       std::span(reports).subspan(begin, end - begin));
  });
  return mean_relative_error(images, reports, frames.truths);
}

ParameterChoice choose_number(const std::string& place, double low, double high, int per_decade,
                              int frames, const ErrorOf& error_of) {
  std::vector<std::pair<double, double>> curve;  // (log10 value, error)
  const auto better = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto error_at = [&](double exponent) {
    const double error = error_of(std::pow(10, exponent));
    curve.emplace_back(exponent, error);
    return error;
  };

  const double step = 1.0 / per_decade;
  double first = std::log10(low);
  double last = first;
  for (error_at(last); last < std::log10(high) - step / 2;) error_at(last += step);
  const auto best_exponent = [&] {
    return std::min_element(curve.begin(), curve.end(), better)->first;
  };
  for (int more = 0; more < 2 * per_decade && best_exponent() == first; ++more) {
    error_at(first -= step);
  }
  for (int more = 0; more < 2 * per_decade && best_exponent() == last; ++more) {
    error_at(last += step);
  }
  const double best = best_exponent();
  if (best == first || best == last) {
    spdlog::warn("{}: \"auto\" found its best value {:.3g} at the end of the range it searched",
                 place, std::pow(10, best));
  }

  // Golden section: the minimum lies in [a, b], c < d divide it. 5 % is 0.02 in log10.
  double a = best - step;
  double b = best + step;
  const double ratio = 1 / std::numbers::phi;
  double c = b - ratio * (b - a);
  double d = a + ratio * (b - a);
  double error_c = error_at(c);
  double error_d = error_at(d);
  while (b - a > 2 * 0.02) {
    if (error_c < error_d) {
      b = std::exchange(d, c);
      error_d = error_c;
      error_c = error_at(c = b - ratio * (b - a));
    } else {
      a = std::exchange(c, d);
      error_c = error_d;
      error_d = error_at(d = a + ratio * (b - a));
    }
  }

  ParameterChoice choice;
  const auto chosen = *std::min_element(curve.begin(), curve.end(), better);
  choice.value = std::pow(10, chosen.first);
  choice.error = chosen.second;
  choice.frames = frames;
  std::sort(curve.begin(), curve.end());
  for (const auto& [exponent, error] : curve) {
    choice.curve.emplace_back(std::pow(10, exponent), error);
  }
  return choice;
}

void Tunable::choose(const Solver& solver, const ValidationFrames& frames, int threads,
                     std::pair<double, double> range, int per_decade,
                     const std::function<void(double)>& set) {
  const auto error_of = [&](double tried) {
    set(tried);
    return mean_relative_error(solver, frames, threads);
  };
  choice = choose_number(place, range.first, range.second, per_decade,
                         static_cast<int>(frames.changes.rows()), error_of);
  value = choice->value;
}

void Tunable::add_to(nlohmann::json& parameters, const std::string& key) const {
  parameters[key] = value ? nlohmann::json(*value) : nlohmann::json("auto");
  if (choice) parameters["chosen"] = to_json(*choice);
}

nlohmann::json to_json(const ParameterChoice& choice) {
  return {{"rule", rule},
          {"value", choice.value},
          {"error", choice.error},
          {"frames", choice.frames},
          {"curve", choice.curve}};
}

void read_chosen(JsonObject& parameters, Tunable& tunable) {
  tunable.choice.reset();
  if (!parameters.has("chosen")) return;
  JsonObject object = parameters.object("chosen");
  ParameterChoice choice;
  object.text("rule");
  choice.value = object.number("value");
  choice.error = object.number("error");
  choice.frames = object.integer("frames", 1, choice_frames);
  try {
    object.raw("curve").get_to(choice.curve);
  } catch (const nlohmann::json::exception&) {
    object.fail("curve", "must be an array of pairs of numbers");
  }
  object.finish();
  if (choice.value == tunable.value) tunable.choice = choice;
}

}  // namespace ertbench
