#include "models/solvers/torch_script_solver.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "models/networks/torch_runtime.h"
#include "models/training/standardisation.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::string first_line(const char* text) { return printable(split(text, "\n").front(), 300); }

std::string shape_text(c10::IntArrayRef sizes) {
  std::string out = "[";
  for (const std::int64_t size : sizes) {
    out += out.size() > 1 ? ", " : "";
    out += std::to_string(size);
  }
  return out + "]";
}

json numbers_json(const Eigen::RowVectorXd& values) {
  if (values.size() == 1) return values[0];
  return std::vector<double>(values.begin(), values.end());
}

}  // namespace

TorchScriptSolver::TorchScriptSolver(JsonObject object)
    : file_(object.text("file")),
      path_(object.folder() / file_),
      float64_(object.choice_or("precision", "float32", {"float32", "float64"}) == "float64"),
      place_(object.source() + ": " + object.path_of("file")),
      mean_(Eigen::RowVectorXd::Zero(1)),
      std_(Eigen::RowVectorXd::Ones(1)) {
  output_ = object.choice_or("output", "change", {"change", "drop"}) == "drop" ? Output::drop
                                                                               : Output::change;
  if (object.has("input") && object.raw("input").is_object()) {
    input_ = Input::given;
    JsonObject given = object.object("input");
    mean_ = read_given(given, "mean", false);
    std_ = read_given(given, "std", true);
    given.finish();
  } else if (object.choice_or("input", "change", {"change", "training"}) == "training") {
    input_ = Input::training;
  }
  if (!std::filesystem::is_regular_file(path_)) {
    object.fail("file", printable_path(file_) + " is no file in " +
                            printable_path(object.folder().string()));
  }
  if (object.has("seed")) seed_ = object.integer("seed", 0, std::numeric_limits<int>::max());
  if (seed_ && file_.find(std::to_string(*seed_)) == std::string::npos) {
    object.fail("seed",
                "the file is the same for every seed; name one of each, \"model-{seed}.pt\"");
  }
  object.finish();
}

Eigen::RowVectorXd TorchScriptSolver::read_given(JsonObject& object, const char* key,
                                                 bool positive) const {
  const json& value = object.raw(key);
  const json list = value.is_array() ? value : json::array({value});
  constexpr std::size_t most = 64 * 61;  // channels of the largest sensor
  bool good = !list.empty() && list.size() <= most;
  Eigen::RowVectorXd out(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; good && i < list.size(); ++i) {
    good = list[i].is_number() && std::isfinite(list[i].get<double>()) &&
           (!positive || list[i].get<double>() > 0);
    if (good) out[static_cast<Eigen::Index>(i)] = list[i].get<double>();
  }
  if (!good) {
    object.fail(key, std::string("must be a number or a list of one for each channel") +
                         (positive ? ", all > 0" : "") + ", got " + json_shown(value));
  }
  return out;
}

json TorchScriptSolver::parameters() const {
  json out = {{"file", file_},
              {"input", input_ == Input::training ? "training" : "change"},
              {"output", output_ == Output::drop ? "drop" : "change"},
              {"precision", float64_ ? "float64" : "float32"}};
  if (input_ == Input::given) {
    out["input"] = {{"mean", numbers_json(mean_)}, {"std", numbers_json(std_)}};
  }
  if (seed_) out["seed"] = *seed_;
  return out;
}

void TorchScriptSolver::check(const Sensor& sensor) const {
  if (input_ != Input::given) return;
  for (const Eigen::RowVectorXd* one : {&mean_, &std_}) {
    if (one->size() != 1 && one->size() != sensor.channels()) {
      throw InputError(place_ + ": \"input\" has " + std::to_string(one->size()) +
                       " numbers, the sensor " + std::to_string(sensor.channels()) + " channels");
    }
  }
}

void TorchScriptSolver::fit(const FitInput& input) {
  start_torch(input.threads);
  if (input_ == Input::training) {
    if (!input.training) {
      throw InputError(place_ + ": \"input\": \"training\" needs the dataset \"train\"");
    }
    const Standardisation of_drops = Standardisation::of(*input.training);
    mean_ = -of_drops.mean.cast<double>();
    std_ = of_drops.scale.cast<double>().cwiseInverse();
  }
  open(input.sensor);
}

void TorchScriptSolver::open(const Sensor& sensor) {
  sensor_ = sensor;
  try {
    module_ = torch::jit::load(path_.string(), torch::kCPU);
    module_.eval();
    module_.to(float64_ ? torch::kFloat64 : torch::kFloat32);
  } catch (const std::exception& error) {
    throw InputError(place_ + ": " + printable_path(file_) +
                     " is no TorchScript module (torch.jit.save): " + first_line(error.what()));
  }
  // Twice and more: the first calls of a module are spent on making it faster.
  constexpr int warm_up = 3;
  for (const std::int64_t frames : {std::int64_t{2}, std::int64_t{1}}) {
    for (int i = 0; i < warm_up; ++i) {
      run(torch::zeros({frames, sensor.channels()}, float64_ ? torch::kFloat64 : torch::kFloat32));
    }
  }
}

torch::Tensor TorchScriptSolver::run(const torch::Tensor& frames) const {
  const torch::NoGradGuard no_gradients;
  const std::string given = "for frames " + shape_text(frames.sizes());
  torch::Tensor out;
  try {
    const torch::IValue result = module_.forward({frames});
    if (!result.isTensor()) {
      throw InputError(place_ + ": " + given + " the module gives no tensor");
    }
    out = result.toTensor();
  } catch (const c10::Error& error) {
    throw InputError(place_ + ": " + given +
                     " the module fails: " + first_line(error.what_without_backtrace()));
  } catch (const std::runtime_error& error) {
    if (dynamic_cast<const InputError*>(&error)) throw;
    // The cause follows the trace of the module's source.
    const std::vector<std::string> lines = split(error.what(), "\n");
    std::string last;
    for (const std::string& line : lines) last = line.empty() ? last : line;
    throw InputError(place_ + ": " + given + " the module fails: " + printable(last, 300));
  }
  const std::int64_t n = frames.size(0);
  const std::int64_t rows = sensor_.image_rows();
  const std::int64_t columns = sensor_.image_columns();
  const std::vector<std::vector<std::int64_t>> shapes = {
      {n, rows * columns}, {n, rows, columns}, {n, 1, rows, columns}};
  const bool fits = std::any_of(shapes.begin(), shapes.end(),
                                [&](const auto& shape) { return out.sizes() == shape; });
  if (!fits) {
    throw InputError(place_ + ": " + given + " the module gives " + shape_text(out.sizes()) +
                     "; it must be " + shape_text(shapes[0]) + ", " + shape_text(shapes[1]) +
                     " or " + shape_text(shapes[2]));
  }
  return out.to(torch::kFloat64).contiguous();
}

void TorchScriptSolver::reconstruct(FramesView changes, ImagesView images,
                                    std::span<FrameReport>) const {
  if (changes.rows() == 0) return;
  const OneThread one_thread;
  torch::Tensor frames = torch::empty({changes.rows(), changes.cols()}, torch::kFloat64);
  Eigen::Map<Frames> fed(frames.data_ptr<double>(), changes.rows(), changes.cols());
  fed = changes;
  if (input_ != Input::change) {
    if (mean_.size() == 1) {
      fed.array() -= mean_[0];
    } else {
      fed.rowwise() -= mean_;
    }
    if (std_.size() == 1) {
      fed /= std_[0];
    } else {
      fed.array().rowwise() /= std_.array();
    }
  }
  if (!float64_) frames = frames.to(torch::kFloat32);
  const torch::Tensor out = run(frames);
  const double unit = output_ == Output::drop ? -sensor_.background : 1;
  images = unit * Eigen::Map<const Images>(out.data_ptr<double>(), images.rows(), images.cols());
}

void TorchScriptSolver::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type, sensor_, parameters());
  out.write_vector("/mean", mean_.transpose());
  out.write_vector("/std", std_.transpose());
  out.close();
}

void TorchScriptSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  {
    const Hdf5File in = open_solver_file(file, type, sensor);
    mean_ = in.read_vector("/mean").transpose();
    std_ = in.read_vector("/std").transpose();
  }
  for (const Eigen::RowVectorXd* one : {&mean_, &std_}) {
    if (one->size() != 1 && one->size() != sensor.channels()) {
      throw InputError(file.string() + ": /mean or /std is not of this sensor; fit it anew");
    }
  }
  start_torch(1);
  open(sensor);
}

}  // namespace ertbench
