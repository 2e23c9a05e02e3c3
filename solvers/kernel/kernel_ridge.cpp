#include "solvers/kernel/kernel_ridge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <tuple>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "forward/sheet/rasterise.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

using Eigen::Index;
using nlohmann::json;

constexpr Index fewest_presses = 3;
/// Share of the least learned strength; a weaker prediction is no contact.
constexpr double least_share = 0.5;

/// In the order of KernelRidge::Position.
const std::array<std::string, 3> position_names = {"regression", "likelihood", "nearest"};

/// Area of a contact, squared domain units.
double area_of(const Contact& contact) {
  switch (contact.shape) {
    case Shape::disc:
    case Shape::ellipse:
      return std::numbers::pi * contact.half_size.prod();
    case Shape::rectangle:
      return 4 * contact.half_size.prod();
    case Shape::polygon:
      break;
  }
  double twice = 0;
  for (std::size_t v = 0; v < contact.vertices.size(); ++v) {
    const Eigen::Vector2d& a = contact.vertices[v];
    const Eigen::Vector2d& b = contact.vertices[(v + 1) % contact.vertices.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

void require_sensor(const DatasetFile& set, const Sensor& sensor) {
  if (set.sensor() == sensor) return;
  throw InputError(set.path().string() + ": is of another sensor; generate it for this one");
}

/// The chosen hyperparameters and their error, for the solver's parameters.
json chosen_json(const ChosenScales& place, const ChosenScales& strength, const Sensor& sensor,
                 Index presses) {
  return {{"presses", presses},
          {"place_error_mm", place.error * sensor.sheet->unit_mm()},
          {"strength_error", strength.error},
          {"rule", "the scales with the least mean leave-one-out error"}};
}

}  // namespace

KernelRidge::KernelRidge(JsonObject parameters) { read(std::move(parameters)); }

void KernelRidge::read(JsonObject parameters) {
  const std::string position = parameters.choice_or("position", position_names[0],
                                                    {position_names.begin(), position_names.end()});
  position_ = static_cast<Position>(
      std::find(position_names.begin(), position_names.end(), position) - position_names.begin());
  input_ = parameters.choice_or("input", "direction", {"direction", "raw"}) == "raw"
               ? KernelInput::raw
               : KernelInput::direction;
  place_choice_ = KernelScaleChoice::from_json(parameters);
  const json none = json::object();
  JsonObject strength = parameters.has("strength")
                            ? parameters.object("strength")
                            : JsonObject(none, parameters.source(), parameters.path_of("strength"));
  strength_choice_ = KernelScaleChoice::from_json(strength);
  strength.finish();
  joins_validation_ =
      parameters.choice_or("validation", "joined", {"joined", "left-out"}) == "joined";
  most_frames_ = parameters.integer_or("most_frames", most_frames_, 3, 20000);
  if (parameters.has("chosen")) parameters.raw("chosen");  // a record of the fit, not a setting
  parameters.finish();
}

json KernelRidge::parameters() const {
  const auto add = [](const KernelScaleChoice& choice, json& out) {
    choice.width.add_to(out, "width");
    choice.lambda.add_to(out, "lambda");
    choice.norm_weight.add_to(out, "norm_weight");
  };
  json out = {{"position", position_names[static_cast<std::size_t>(position_)]},
              {"input", input_ == KernelInput::raw ? "raw" : "direction"},
              {"validation", joins_validation_ ? "joined" : "left-out"},
              {"most_frames", most_frames_},
              {"strength", json::object()}};
  add(place_choice_, out);
  add(strength_choice_, out["strength"]);
  if (presses_.changes.rows() > 0) {
    json& chosen = out["chosen"] =
        chosen_json(place_scales_, strength_scales_, sensor_, presses_.places.rows());
    if (position_ == Position::nearest) chosen["neighbours"] = neighbours_;
    if (position_ == Position::likelihood) {
      chosen["likelihood"] = {{"width", likelihood_.width},
                              {"lambda", likelihood_.lambda},
                              {"shrinkage", likelihood_.shrinkage},
                              {"sharpness", likelihood_.sharpness}};
    }
  }
  return out;
}

void KernelRidge::learn(const FitInput& input) {
  std::vector<Eigen::RowVectorXd> frames, blank;
  std::vector<Eigen::Vector2d> places;
  std::vector<double> strengths;
  double areas = 0;
  const auto add = [&](const DatasetFile& set) {
    require_sensor(set, input.sensor);
    const std::vector<Scene> scenes = set.scenes(0, set.size());
    for (std::uint64_t f = 0; f < set.size(); ++f) {
      const bool full = std::ssize(frames) + std::ssize(blank) >= most_frames_;
      if (scenes[f].contacts.size() > 1 || full) continue;
      const Eigen::RowVectorXd change =
          set.voltages(f, 1).row(0) - set.reference_voltages().transpose();
      if (scenes[f].contacts.empty()) {
        // In a set without contact positions, no contact means that they are unknown.
        if (set.truth().places) blank.push_back(change);
        continue;
      }
      const Contact& contact = scenes[f].contacts.front();
      const double area = area_of(contact);
      frames.push_back(change);
      places.push_back(contact.centroid());
      strengths.push_back(area * (contact.conductivity_ratio - 1) * set.sensor().background);
      areas += area;
    }
  };
  add(*input.training);
  if (joins_validation_ && input.validation != nullptr) add(*input.validation);
  const auto touched = static_cast<Index>(frames.size());
  if (touched < fewest_presses) {
    throw InputError(input.training->path().string() + ": kernel-ridge learns from frames with " +
                     "one contact each, of which there are " + std::to_string(touched) +
                     "; it needs " + std::to_string(fewest_presses) + " or more");
  }
  presses_.area = areas / static_cast<double>(touched);
  presses_.places.resize(touched, 2);
  for (Index i = 0; i < touched; ++i) presses_.places.row(i) = places[static_cast<std::size_t>(i)];
  frames.insert(frames.end(), blank.begin(), blank.end());
  presses_.strengths = Eigen::VectorXd::Zero(std::ssize(frames));
  std::copy(strengths.begin(), strengths.end(), presses_.strengths.begin());
  presses_.changes.resize(std::ssize(frames), input.sensor.channels());
  for (Index i = 0; i < std::ssize(frames); ++i) {
    presses_.changes.row(i) = frames[static_cast<std::size_t>(i)];
  }
}

void KernelRidge::fit(const FitInput& input) {
  if (input.training == nullptr) {
    throw InputError(std::string(type) + R"(: needs a training set; add "train" to the datasets)");
  }
  sensor_ = input.sensor;
  learn(input);
  choose_position();
  strength_scales_ = choose_scales(strength_choice_, input_, presses_.changes, presses_.strengths);
  const auto fix = [](const KernelScales& scales, KernelScaleChoice& choice) {
    choice.width.value = scales.width;
    choice.lambda.value = scales.lambda;
    choice.norm_weight.value = scales.norm_weight;
  };
  fix(place_scales_.scales, place_choice_);
  fix(strength_scales_.scales, strength_choice_);
  regress();
}

void KernelRidge::choose_position() {
  const RowMajorMatrix changes = presses_.changes.topRows(presses_.places.rows());
  if (position_ == Position::likelihood) {
    const ChosenLikelihood chosen = choose_likelihood(changes, presses_.places);
    likelihood_ = chosen.scales;
    place_scales_.error = chosen.error;
  } else if (position_ == Position::nearest) {
    std::tie(neighbours_, place_scales_.error) = NearestPresses::choose(changes, presses_.places);
  } else {
    place_scales_ = choose_scales(place_choice_, input_, changes, presses_.places);
  }
}

void KernelRidge::regress() {
  const Index touched = presses_.places.rows();
  const RowMajorMatrix changes = presses_.changes.topRows(touched);
  const auto place_by = [&](auto model) {
    return [model = std::make_shared<const decltype(model)>(std::move(model))](
               const Eigen::RowVectorXd& change) { return model->position(change); };
  };
  if (position_ == Position::likelihood) {
    place_ = place_by(PositionLikelihood(changes, presses_.places, likelihood_));
  } else if (position_ == Position::nearest) {
    place_ = place_by(NearestPresses(changes, presses_.places, neighbours_));
  } else {
    place_ = place_by(KernelRegression(changes, presses_.places, input_, place_scales_.scales));
  }
  strength_ =
      KernelRegression(presses_.changes, presses_.strengths, input_, strength_scales_.scales);
  least_strength_ = least_share * presses_.strengths.head(touched).cwiseAbs().minCoeff();
}

std::optional<KernelRidge::Press> KernelRidge::press_of(
    const Eigen::Ref<const Eigen::RowVectorXd>& change) const {
  // A copy: the alignment of a row in an array changes the order of sums, and so last bits.
  const Eigen::RowVectorXd own = change;
  if (!own.allFinite() || !(own.norm() > 0)) return std::nullopt;
  const double strength = strength_.predict(own)(0, 0);
  if (!(std::abs(strength) >= least_strength_)) return std::nullopt;
  return Press{place_(own), strength};
}

void KernelRidge::reconstruct(FramesView changes, ImagesView images, std::span<FrameReport>) const {
  const PixelGrid pixels = sensor_.image();
  Scene scene;
  scene.contacts.resize(1);
  scene.contacts[0].half_size.setConstant(std::sqrt(presses_.area / std::numbers::pi));
  scene.contacts[0].conductivity_ratio = 0.5;
  Eigen::VectorXd ratio(pixels.count());
  for (Index f = 0; f < changes.rows(); ++f) {
    images.row(f).setZero();
    const auto press = press_of(changes.row(f));
    if (!press) continue;
    scene.contacts[0].centre = press->place;
    rasterise(scene, pixels, Rasterisation::area, ratio);
    // 1 - ratio is half of the covered share of a pixel. No conductivity falls below 0.
    const double change =
        std::max(press->strength / presses_.area, -(1 - 1e-6) * sensor_.background);
    images.row(f) = 2 * change * (1 - ratio.array()).matrix().transpose();
  }
}

void KernelRidge::find_contacts(FramesView changes,
                                std::span<std::vector<FoundContact>> contacts) const {
  for (Index f = 0; f < changes.rows(); ++f) {
    std::vector<FoundContact>& out = contacts[static_cast<std::size_t>(f)];
    out.clear();
    const auto press = press_of(changes.row(f));
    if (!press) continue;
    FoundContact& found = out.emplace_back();
    found.place = press->place;
    found.strength = std::abs(press->strength);
    found.area = presses_.area;
    found.peak = found.strength / found.area;
  }
}

void KernelRidge::save(const std::filesystem::path& file) const {
  json parameters = this->parameters();
  Hdf5File out = create_solver_file(file, type, sensor_, parameters);
  out.write_matrix("/changes", presses_.changes);
  out.write_matrix("/places", presses_.places);
  out.write_vector("/strengths", presses_.strengths);
  out.write_vector("/numbers",
                   Eigen::Vector3d(presses_.area, place_scales_.error, strength_scales_.error));
  out.write_vector("/position", (Eigen::VectorXd(5) << likelihood_.width, likelihood_.lambda,
                                 likelihood_.shrinkage, likelihood_.sharpness, neighbours_)
                                    .finished());
  out.close();
}

void KernelRidge::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File in = open_solver_file(file, type, sensor);
  read(JsonObject(parameters_of_fit(in), file.string(), "/parameters"));
  const auto scales_of = [&](const KernelScaleChoice& choice) {
    if (!choice.width.value || !choice.lambda.value || !choice.norm_weight.value) {
      throw InputError(file.string() + ": has no scales; fit the solver again");
    }
    return KernelScales{*choice.width.value, *choice.lambda.value, *choice.norm_weight.value};
  };
  const auto channels = static_cast<std::uint64_t>(sensor.channels());
  const std::uint64_t frames = in.require_shape("/changes", {0, channels})[0];
  const std::uint64_t touched = in.require_shape("/places", {0, 2})[0];
  in.require_shape("/strengths", {frames});
  in.require_shape("/numbers", {3});
  if (touched > frames || frames > 40000 || touched < 2) {
    throw InputError(file.string() + ": /places: does not go with /changes; fit the solver again");
  }
  sensor_ = sensor;
  presses_.changes = in.read_rows("/changes", 0, frames);
  presses_.places = in.read_rows("/places", 0, touched);
  presses_.strengths = in.read_vector("/strengths");
  const Eigen::VectorXd numbers = in.read_vector("/numbers");
  if (!(numbers[0] > 0)) throw InputError(file.string() + ": /numbers: the area must be > 0");
  presses_.area = numbers[0];
  in.require_shape("/position", {5});
  const Eigen::VectorXd position = in.read_vector("/position");
  if (!(position.minCoeff() > 0)) throw InputError(file.string() + ": /position: must be > 0");
  likelihood_ = {position[0], position[1], std::min(position[2], 1.0), position[3]};
  neighbours_ = static_cast<int>(std::clamp(position[4], 1.0, 40000.0));
  place_scales_ = {scales_of(place_choice_), numbers[1]};
  strength_scales_ = {scales_of(strength_choice_), numbers[2]};
  regress();
}

std::vector<SolverType> kernel_solvers() {
  SolverInfo info;
  info.summary =
      "kernel ridge regression from voltages to the place and the strength of one contact, its "
      "scales by leave-one-out";
  info.parameters = {
      {"position",
       "\"regression\" from the voltages to the place (the default); \"likelihood\": regression "
       "from the place to the voltages, and the mean place under the frame's likelihood, which "
       "needs far fewer presses; \"nearest\": the mean place of the presses with the nearest "
       "directions"},
      {"input",
       "what frames are compared by: \"direction\" of their change, its norm apart (the default), "
       "or the \"raw\" change"},
      {"width",
       "of the radial basis, over the median squared distance of the training frames, 1e-6 ... "
       "1e6, or \"auto\" (the default)"},
      {"lambda", "the ridge, 1e-12 ... 1e6 or \"auto\" (the default)"},
      {"norm_weight",
       "of the logarithm of the norm beside the direction, 0 ... 1e6 or \"auto\" (the default)"},
      {"strength",
       "the same three of the regression to the contact's strength, {\"width\", \"lambda\", "
       "\"norm_weight\"}; default \"auto\""},
      {"validation",
       "\"joined\" (the default): the validation set is learned from as well, for nothing is "
       "chosen on it; or \"left-out\""},
      {"most_frames", "learned from, 3 ... 20000; default 2000"}};
  info.make = make_from_json<KernelRidge>;
  info.probes = {"{}", R"({"input": "raw"})", R"({"position": "likelihood"})",
                 R"({"position": "nearest"})"};
  return {{KernelRidge::type, info}};
}

}  // namespace ertbench
