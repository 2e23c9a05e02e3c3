#include "models/solvers/learned_solver.h"

#include <torch/serialize/archive.h>
#include <torch/utils.h>

#include "core/errors.h"
#include "core/json_reader.h"
#include "forward/data/dataset_file.h"
#include "models/networks/torch_runtime.h"

namespace ertbench {
namespace {

using nlohmann::json;
using torch::serialize::InputArchive;
using torch::serialize::OutputArchive;

/// Raised whenever an older file would be read wrongly, or the same settings train otherwise.
constexpr int learned_file_version = 1;

torch::Tensor tensor_of(const Eigen::RowVectorXf& row) {
  return torch::from_blob(const_cast<float*>(row.data()), {row.size()}).clone();
}

Eigen::RowVectorXf row_of(InputArchive& archive, const std::string& name, int size) {
  torch::Tensor tensor;
  archive.read(name, tensor);
  if (tensor.numel() != size || tensor.dtype() != torch::kFloat32) {
    throw std::runtime_error(name + " has another size");
  }
  return Eigen::Map<const Eigen::RowVectorXf>(tensor.contiguous().data_ptr<float>(), size);
}

torch::Tensor tensor_of(const Eigen::VectorXd& values) {
  return torch::from_blob(const_cast<double*>(values.data()), {values.size()}, torch::kFloat64)
      .clone();
}

/// Empty in a file from before there was a check.
Eigen::VectorXd frame_check_of(InputArchive& archive) {
  torch::Tensor tensor;
  if (!archive.try_read("frame_check", tensor)) return {};
  if (tensor.dtype() != torch::kFloat64) throw std::runtime_error("frame_check has another type");
  const torch::Tensor values = tensor.contiguous();
  return Eigen::Map<const Eigen::VectorXd>(values.data_ptr<double>(), values.numel());
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

void copy_weights(const Network& from, Network& to) {
  const torch::NoGradGuard no_gradients;
  const auto copy = [](const std::vector<torch::Tensor>& source,
                       std::vector<torch::Tensor> target) {
    for (std::size_t i = 0; i < source.size(); ++i) target.at(i).copy_(source[i]);
  };
  copy(from.parameters(), to.parameters());
  copy(from.buffers(), to.buffers());
}

}  // namespace

void LearnedSolver::read_inference(JsonObject& object) {
  bfloat16_inference_ =
      object.choice_or("inference_precision", "float32", {"float32", "bfloat16"}) == "bfloat16";
}

json LearnedSolver::parameters() const {
  json out = settings();
  if (bfloat16_inference_) out["inference_precision"] = "bfloat16";
  out.update(to_json(training_));
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
  const json runtime = start_torch(input.threads);
  torch::manual_seed(training_.seed);

  standardisation_ = Standardisation::of(training);
  const std::shared_ptr<Network> network = make_network(input.sensor);
  initialise(*network, input, standardisation_);
  const std::unique_ptr<Objective> objective = make_objective(input);
  TrainingSet scenes(training, standardisation_, training_);
  const TrainingResult result =
      train(*network, *objective, scenes, ValidationSet(validation, standardisation_), training_,
            {.folder = input.work_folder, .progress = input.progress});
  result_ = to_json(result);
  result_["scenes"] = training.size();
  result_["runtime"] = runtime;
  freeze(input.sensor, network);
}

void LearnedSolver::freeze(const Sensor& sensor, std::shared_ptr<Network> network) {
  sensor_ = sensor;
  network_ = std::move(network);
  if (bfloat16_inference_) {  // rounds a copy: the network itself is what `save` writes
    const std::shared_ptr<Network> rounded = make_network(sensor);
    copy_weights(*network_, *rounded);
    graph_.emplace(*rounded, sensor.channels(), true);
    return;
  }
  graph_.emplace(*network_, sensor.channels());
}

void LearnedSolver::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport>) const {
  const OneThread one_thread;
  const torch::Tensor y = graph_->run(standardisation_.apply(changes)).contiguous();
  using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  images =
      -sensor_.background *
      Eigen::Map<const FloatRows>(y.data_ptr<float>(), images.rows(), images.cols()).cast<double>();
}

void LearnedSolver::save(const std::filesystem::path& file) const {
  json parameters = settings();
  parameters.update(to_json(training_));
  const json description = {{"solver", type_},
                            {"format_version", learned_file_version},
                            {"sensor", to_json(sensor_)},
                            {"parameters", parameters},
                            {"training", result_}};
  OutputArchive archive;
  archive.write("ertbench", torch::IValue(description.dump()));
  archive.write("mean", tensor_of(standardisation_.mean));
  archive.write("scale", tensor_of(standardisation_.scale));
  archive.write("frame_check", tensor_of(frame_check_));
  OutputArchive network;
  network_->save(network);
  archive.write("network", network);
  archive.save_to(file.string());
}

void LearnedSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  const std::string name = file.string();
  InputArchive archive;
  json description;
  try {
    archive.load_from(name);
    torch::IValue text;
    archive.read("ertbench", text);
    description = json::parse(text.toStringRef());
  } catch (const std::exception&) {
    throw InputError(name + ": is not the file of a fitted network, or damaged");
  }
  JsonObject object(description, name, "/ertbench");
  if (const std::string found = object.text("solver"); found != type_) {
    throw InputError(name + ": holds a fitted \"" + found + "\", not a \"" + type_ + "\"");
  }
  if (const int found = object.integer("format_version", 0, 1000000);
      found != learned_file_version) {
    throw InputError(name + ": has format version " + std::to_string(found) +
                     ", this program reads " + std::to_string(learned_file_version) +
                     "; train the network anew");
  }
  if (sensor_from_json(object.object("sensor")) != sensor) {
    throw InputError(name + ": was trained for the sensor " + description.at("sensor").dump() +
                     ", asked for is " + to_json(sensor).dump() + "; train it for this one");
  }
  read(object.object("parameters"));
  start_torch(1);
  try {
    const std::shared_ptr<Network> network = make_network(sensor);
    InputArchive weights;
    archive.read("network", weights);
    network->load(weights);
    standardisation_.mean = row_of(archive, "mean", sensor.channels());
    standardisation_.scale = row_of(archive, "scale", sensor.channels());
    frame_check_ = frame_check_of(archive);
    result_ = description.at("training");
    fit_report();  // throws where it is not what a training reports
    freeze(sensor, network);
  } catch (const std::exception& error) {
    throw InputError(name + ": its weights do not fit its settings: " +
                     std::string(error.what()).substr(0, 200));
  }
}

}  // namespace ertbench
