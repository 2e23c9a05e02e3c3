#include "models/solvers/learned_solver.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/errors.h"
#include "core/fields.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/sheet_model.h"
#include "models/networks/tensor_file.h"
#include "models/networks/torch_runtime.h"
#include "solvers/linear/one_step_gn.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

constexpr double cut_share = 0.25;

/// Images [frames, pixels] of `changes` [frames, channels] by one-step Gauss-Newton.
Images gauss_newton(const FitInput& input, const nlohmann::json& parameters,
                    const Frames& changes) {
  OneStepGaussNewton solver(JsonObject(parameters, "one-step-gn", ""));
  solver.fit(input);
  Images images(changes.rows(), input.sensor.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(changes.rows()));
  solver.reconstruct(changes, images, reports);
  return images;
}

}  // namespace

RowMajorMatrix sensitivity_inverse(const FitInput& input) {
  const int channels = input.sensor.channels();
  return gauss_newton(input, {{"prior", "noser"}}, Frames::Identity(channels, channels))
      .transpose();
}

void set_sensitivity_inverse(torch::nn::Linear& layer, const FitInput& input,
                             const Standardisation& standardisation) {
  // y = -G (v - v0) / (c0 image), and v0 - v = mean + x / scale.
  const Eigen::MatrixXf inverse =
      (sensitivity_inverse(input) / (input.sensor.background * standardisation.image))
          .cast<float>();
  const FloatRows weight = inverse * standardisation.scale.cwiseInverse().asDiagonal();
  const Eigen::VectorXf bias = inverse * standardisation.mean.transpose();
  const torch::NoGradGuard no_gradients;
  layer->weight.zero_();  // what the network is told weighs nothing
  layer->weight.slice(1, 0, weight.cols()).copy_(tensor_of(weight));
  layer->bias.copy_(tensor_of(bias.transpose()).flatten());
}

RowMajorMatrix spatial_blur(const FitInput& input, std::optional<double> lambda) {
  nlohmann::json parameters = {{"prior", "laplace"}};
  if (lambda) parameters["lambda"] = *lambda;
  const RowMajorMatrix jacobian = uniform_jacobian(input.sensor);
  RowMajorMatrix blur = gauss_newton(input, parameters, jacobian.transpose()).transpose();
  for (Eigen::Index column = 0; column < blur.cols(); ++column) {
    const double least = cut_share * blur.col(column).maxCoeff();
    blur.col(column) = (blur.col(column).array() < least).select(0.0, blur.col(column));
  }
  return blur;
}

namespace {

using nlohmann::json;

Eigen::RowVectorXf read_row(const Hdf5File& file, const std::string& dataset, int size) {
  const torch::Tensor row = read_tensor(file, dataset, torch::empty({size}));
  return Eigen::Map<const Eigen::RowVectorXf>(row.data_ptr<float>(), size);
}

/// Standardisation::image; 1 in files from before the attribute existed.
double read_image_unit(const Hdf5File& file) {
  if (!file.has_attribute("/", "image_unit")) return 1;
  const double unit = file.read_number("/", "image_unit");
  if (!std::isfinite(unit) || unit == 0) {
    throw InputError(file.path().string() + ": attribute \"image_unit\" of / is no number");
  }
  return unit;
}

/// Rejects the format of fitted networks up to version 0.2.
void refuse_torch_archive(const std::filesystem::path& file) {
  char start[2] = {};
  std::ifstream(file, std::ios::binary).read(start, sizeof start);
  if (start[0] != 'P' || start[1] != 'K') return;
  throw InputError(file.string() +
                   ": is a torch archive, in which versions up to 0.2 kept a fitted network; such "
                   "an archive is code that runs when it is loaded, and is not read any more; fit "
                   "the solver anew");
}

const DatasetFile& required(const DatasetFile* set, const std::string& type, const char* name,
                            const Sensor& sensor) {
  if (!set) {
    throw InputError(type + " is trained and needs the dataset \"" + name +
                     "\"; add it to the experiment, or name a fitted file in \"checkpoint\"");
  }
  if (set->sensor() != sensor) {
    throw InputError(set->path().string() + ": is of another sensor; generate it for this one");
  }
  return *set;
}

}  // namespace

void LearnedSolver::read_inference(JsonObject& object) {
  bfloat16_inference_ =
      object.choice_or("inference_precision", "float32", {"float32", "bfloat16"}) == "bfloat16";
}

void LearnedSolver::read(JsonObject object) {
  training_ = standard_training_;
  Fields::read(std::move(object), [&](Fields& fields) {
    visit(fields);
    ertbench::visit(fields, training_);
  });
}

void LearnedSolver::visit_front(Fields& fields) {
  // Written where it is on: files of older networks have none.
  if (!fields.writing() || told_) fields.boolean("front", told_);
}

json LearnedSolver::settings() const {
  return Fields::written([&](Fields& fields) {
    // Fields that are written are not changed.
    const_cast<LearnedSolver*>(this)->visit(fields);
    TrainingSettings training = training_;
    ertbench::visit(fields, training);
  });
}

json LearnedSolver::parameters() const {
  json out = settings();
  if (bfloat16_inference_) out["inference_precision"] = "bfloat16";
  if (!result_.is_null()) out["training"] = result_;
  return out;
}

FitReport LearnedSolver::fit_report() const {
  if (result_.is_null()) return {};
  return training_result_from_json(result_).report;
}

void LearnedSolver::fit(const FitInput& input) {
  const DatasetFile& training = required(input.training, type_, "train", input.sensor);
  const DatasetFile& validation = required(input.validation, type_, "validation", input.sensor);
  if (training.size() < 2)
    throw InputError(training.path().string() + ": needs two scenes or more");
  if (training_.faults.dead_electrodes.second > input.sensor.electrode_count - 5) {
    throw InputError(type_ +
                     ": /training_faults/dead_electrodes: must leave five electrodes of the " +
                     std::to_string(input.sensor.electrode_count) + " or more");
  }
  json runtime = start_torch(input.threads);
  const torch::Device device = training_device(training_.device);
  runtime["device"] = device.str();
  torch::manual_seed(training_.seed);

  standardisation_ = Standardisation::of(training);
  const std::shared_ptr<Network> network = make_network(input.sensor);
  initialise(*network, input, standardisation_);
  const std::unique_ptr<Objective> objective = make_objective(input);
  std::optional<Front> front;
  if (is_told()) front.emplace(input.sensor, FrameCheck(input, 0));
  const Front* const told = front ? &*front : nullptr;
  TrainingSet scenes(training, standardisation_, training_, told);
  const TrainingResult result = train(*network, *objective, scenes,
                                      ValidationSet(validation, standardisation_, told), training_,
                                      {.folder = input.work_folder,
                                       .progress = input.progress,
                                       .on = {device, input.threads, device.is_cuda()}});
  result_ = to_json(result);
  result_["scenes"] = training.size();
  result_["runtime"] = runtime;
  freeze(input.sensor, network);
}

Frames LearnedSolver::usual_frames(const FitInput& input) const {
  constexpr std::uint64_t most = 4000;
  TrainingSettings settings = training_;
  settings.new_scenes = false;
  settings.faults.dead_electrodes = {0, 0};
  if (!settings.faults || !input.validation) return {};
  TrainingSet scenes(*input.validation, standardisation_, settings);
  Frames out(0, input.sensor.channels());
  for (std::uint64_t epoch = 0; epoch == 0 || (epoch + 1) * scenes.size() <= most; ++epoch) {
    scenes.begin_epoch(epoch);
    const torch::Tensor drawn = scenes.batch(0, scenes.size()).frames.contiguous();
    const float* frame = drawn.data_ptr<float>();
    out.conservativeResize(out.rows() + drawn.size(0), Eigen::NoChange);
    for (Eigen::Index f = out.rows() - drawn.size(0); f < out.rows(); ++f) {
      const Eigen::Map<const Eigen::RowVectorXf> row(frame, out.cols());
      out.row(f) =
          -(row.cwiseQuotient(standardisation_.scale) + standardisation_.mean).cast<double>();
      frame += drawn.size(1);
    }
  }
  return out;
}

void LearnedSolver::freeze(const Sensor& sensor, std::shared_ptr<Network> network) {
  sensor_ = sensor;
  network_ = std::move(network);
  if (is_told()) front_.emplace(sensor);
  plan_ = network_->plan(PlanBuilder(bfloat16_inference_));
  graph_.reset();
  if (!batches_share_weights() && plan_) return;
  if (bfloat16_inference_) {  // rounds a copy: the network itself is what `save` writes
    const std::shared_ptr<Network> rounded = make_network(sensor);
    copy_values(weights_of(*network_), weights_of(*rounded));
    graph_.emplace(*rounded, sensor.channels() + told(sensor), true);
    return;
  }
  graph_.emplace(*network_, sensor.channels() + told(sensor));
}

void LearnedSolver::enter(const FramesView& changes, Eigen::Index frame,
                          std::span<const FrameReport> reports, float* inputs) const {
  standardisation_.apply(changes.row(frame), inputs);
  if (!front_) return;
  front_->tell(changes.row(frame).data(), reports[static_cast<std::size_t>(frame)].dead,
               inputs + changes.cols());
}

void LearnedSolver::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) const {
  const double unit = -sensor_.background * standardisation_.image;
  if (graph_ && (changes.rows() > 1 || !plan_)) {
    const OneThread one_thread;
    torch::Tensor frames = torch::empty({changes.rows(), changes.cols() + told(sensor_)});
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      enter(changes, f, reports, frames.data_ptr<float>() + f * frames.size(1));
    }
    const torch::Tensor y = graph_->run(frames).contiguous();
    images = unit * Eigen::Map<const FloatRows>(y.data_ptr<float>(), images.rows(), images.cols())
                        .cast<double>();
    return;
  }
  // Buffers of the thread, so that a frame allocates nothing.
  thread_local Eigen::RowVectorXf frame;
  thread_local Eigen::RowVectorXf y;
  frame.resize(changes.cols() + told(sensor_));
  y.resize(images.cols());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    enter(changes, f, reports, frame.data());
    plan_->run(frame.data(), y.data());
    images.row(f) = unit * y.cast<double>();
  }
}

std::optional<LayerList> LearnedSolver::layers() const {
  LayerList out;
  if (!network_ || !network_->plan(PlanBuilder(false, &out.layers))) return std::nullopt;
  // (-change - mean) scale is (change - (-mean)) (-scale), to the last bit.
  const Eigen::RowVectorXf shift = -standardisation_.mean;
  const Eigen::RowVectorXf scale = -standardisation_.scale;
  out.shift.assign(shift.begin(), shift.end());
  out.scale.assign(scale.begin(), scale.end());
  out.unit = -sensor_.background * standardisation_.image;
  return out;
}

void LearnedSolver::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type_, sensor_, settings());
  out.write_text("/", "training", result_.dump());
  write_tensor(out, "/mean", tensor_of(standardisation_.mean).flatten());
  write_tensor(out, "/scale", tensor_of(standardisation_.scale).flatten());
  out.write_number("/", "image_unit", standardisation_.image);
  write_tensors(out, "/network", weights_of(*network_));
  out.close();
}

void LearnedSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  refuse_torch_archive(file);
  const Hdf5File in = open_solver_file(file, type_, sensor);
  const json parameters = parameters_of_fit(in);
  read(JsonObject(parameters, file.string(), "/parameters"));
  result_ = json_attribute(in, "training");
  start_torch(1);
  try {
    fit_report();  // throws if it is no report of a training
    standardisation_.mean = read_row(in, "/mean", sensor.channels());
    standardisation_.scale = read_row(in, "/scale", sensor.channels());
    standardisation_.image = read_image_unit(in);
    const std::shared_ptr<Network> network = make_network(sensor);
    const NamedTensors weights = weights_of(*network);
    copy_values(read_tensors(in, "/network", weights), weights);
    freeze(sensor, network);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; fit the solver anew");
  } catch (const std::exception& error) {
    throw InputError(file.string() + ": does not fit its parameters: " +
                     std::string(error.what()).substr(0, 200) + "; fit the solver anew");
  }
}

}  // namespace ertbench
