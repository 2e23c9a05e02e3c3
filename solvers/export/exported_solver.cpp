#include "solvers/export/exported_solver.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/process.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/sheet_model.h"
#include "solvers/channel_mask.h"
#include "solvers/check/checked_solver.h"
#include "solvers/check/stored_solver.h"
#include "solvers/front/front.h"
#include "solvers/layered_solver.h"
#include "solvers/solver_file.h"

namespace ertbench {

namespace fs = std::filesystem;
using nlohmann::json;

SolverToExport load_to_export(const fs::path& file, const MakeSolver& make, bool front) {
  std::string type;
  Sensor sensor;
  json entry = {{"checkpoint", fs::absolute(file).string()}};
  {
    const Hdf5File in = Hdf5File::open(file);
    if (!in.has_attribute("/", "solver")) {
      throw InputError(file.string() + ": is not the file of a fitted solver");
    }
    type = in.read_text("/", "solver");
    // A mixture is a class of its own.
    const json fitted = parameters_of_fit(in);
    if (fitted.contains("components")) entry["components"] = fitted["components"];
    const json said = json_attribute(in, "sensor");
    sensor = sensor_from_json(JsonObject(said, file.string(), "/sensor"));
  }
  entry["type"] = type;
  std::unique_ptr<Solver> solver = make(JsonObject(entry, file.string(), ""));
  FitInput input;
  input.sensor = sensor;
  solver->fit(input);
  const auto* const checked = dynamic_cast<const CheckedSolver*>(solver.get());
  const auto* const layered = checked ? checked->inner_as<LayeredSolver>() : nullptr;
  const auto* const told = checked ? checked->inner_as<ToldSolver>() : nullptr;
  try {
    const std::optional<LayerList> list = layered ? layered->layers() : std::nullopt;
    if (!list) {
      throw InputError(type + " has no layers that could be exported; take a linear method " +
                       "or a network without self-attention");
    }
    SolverToExport out = {sensor, std::move(solver), *list, ExportProgram(*list), {}, {}};
    const bool is_told = told && told->is_told();
    if (!front && !is_told) return out;
    out.frame_check = CheckedFile(file, {type, sensor}).frame_check().value_or(Eigen::VectorXd());
    if (out.frame_check.size() <= sensor.channels()) {
      throw InputError("was fitted on too few frames for a front; fit it on 100 or more");
    }
    const ElectrodeSet masked = out.solver->masked_channels().electrodes;
    out.front = FrameCheck(sensor, masked, out.frame_check).front(sensor);
    out.front.told = is_told ? Front::told(sensor) : 0;
    return out;
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

std::vector<double> calibrate(SolverToExport& exported, Frames changes) {
  if (exported.program.steps().back().kind == ExportStep::Kind::mixture) {
    throw InputError(
        "weighs estimates by exponentials, for which integers are too coarse; take "
        "the precision float32 or float16");
  }
  const Eigen::Index told = exported.front.told;
  if (told > 0) {
    const Sensor& sensor = exported.sensor;
    const Front front(sensor, FrameCheck(sensor, 0, exported.frame_check));
    const std::vector<ElectrodeSet> users = electrode_sets_of_channels(sensor);
    const Eigen::VectorXd reference = uniform_reference(sensor);
    const Eigen::Index channels = changes.cols();
    changes.conservativeResize(Eigen::NoChange, channels + told);
    std::vector<float> numbers(static_cast<std::size_t>(told));
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      for (Eigen::Index c = 0; c < channels && f % 2 == 1; ++c) {
        const auto dead = f / 2 % sensor.electrode_count;
        if (users[static_cast<std::size_t>(c)] >> dead & 1) changes(f, c) = -reference[c];
      }
      front.prepare(changes.row(f).data(), numbers.data());
      for (Eigen::Index i = 0; i < told; ++i) {
        changes(f, channels + i) = static_cast<double>(numbers[static_cast<std::size_t>(i)]);
      }
    }
  }
  exported.program.equalise_input(changes);
  return exported.program.ranges(changes);
}

namespace {

constexpr double compile_limit_s = 600;

/// Calls by names that do not depend on the solver.
constexpr const char* calls = R"c(#include "solver.h"
unsigned long ert_state_bytes(void) { return sizeof(ErtSolver); }
void ert_frame(void *state, const float *changes, float *image)
{
  static const float none[ERT_CHANNELS];
  ert_start((ErtSolver *)state);
  ert_set_reference((ErtSolver *)state, none);
  ert_image((ErtSolver *)state, changes, image);
}
)c";

std::vector<std::string> compiler() {
  const char* const chosen = std::getenv("CC");
  return {
      chosen && *chosen ? chosen : "cc", "-std=c99", "-O3", "-march=native", "-shared", "-fPIC"};
}

}  // namespace

/// The compiled code.
class ExportedSolver::Library {
 public:
  explicit Library(const std::map<std::string, std::string>& files) : folder_("export") {
    for (const auto& [name, text] : files) write_file_atomically(folder_.path() / name, text);
    write_file_atomically(folder_.path() / "calls.c", calls);
    std::vector<std::string> words = compiler();
    words.insert(words.end(), {"-o", "solver.so", "solver.c", "weights.c", "calls.c", "-lm"});
    const fs::path log = folder_.path() / "compiler.log";
    const ProcessEnd end =
        ChildProcess(words, {.log = log, .folder = folder_.path()}, {.time_s = compile_limit_s})
            .wait();
    if (!end.ok()) {
      throw InputError("the C compiler " + printable(words[0]) + ": " + end.text() + ": " +
                       printable(contents_of(log), 500) + "; install one, or name it in $CC");
    }
    handle_ = ::dlopen((folder_.path() / "solver.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle_) throw InputError(std::string("the exported solver: ") + ::dlerror());
    frame_ = reinterpret_cast<Frame>(::dlsym(handle_, "ert_frame"));
    const auto bytes = reinterpret_cast<unsigned long (*)()>(::dlsym(handle_, "ert_state_bytes"));
    state_numbers_ = (bytes() + sizeof(double) - 1) / sizeof(double);
  }
  ~Library() {
    if (handle_) ::dlclose(handle_);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  void frame(double* state, const float* changes, float* image) const {
    frame_(state, changes, image);
  }
  std::size_t state_numbers() const { return state_numbers_; }  ///< doubles

 private:
  using Frame = void (*)(void*, const float*, float*);
  TemporaryFolder folder_;
  void* handle_ = nullptr;
  Frame frame_ = nullptr;
  std::size_t state_numbers_ = 0;
};

ExportedSolver::ExportedSolver(JsonObject object, MakeSolver make)
    : of_(object.text("of")), make_(std::move(make)) {
  try {
    fitted_ = fitted_file(of_, object.folder());
  } catch (const InputError& error) {
    object.fail("of", error.what());
  }
  object.choice_or("to", "c", {"c"});
  precision_ =
      precision_from_name(object.choice_or("precision", "float32", {"float32", "float16", "int8"}));
  object.finish();
}

ExportedSolver::~ExportedSolver() = default;

json ExportedSolver::parameters() const {
  return {{"of", of_}, {"to", "c"}, {"precision", name_of(precision_)}};
}

void ExportedSolver::compile(const Sensor& sensor, const Frames& calibration) {
  library_.reset();
  SolverToExport exported = load_to_export(fitted_, make_);
  if (exported.sensor != sensor) {
    throw InputError(fitted_.string() + ": was fitted for another sensor");
  }
  sensor_ = sensor;
  has_front_ = exported.front.electrodes > 0;
  CExport how{
      .name = of_, .sensor = sensor, .precision = precision_, .rule = {}, .front = exported.front};
  if (precision_ == ExportPrecision::int8) {
    calibration_ = calibration;
    how.ranges = calibrate(exported, calibration);
  }
  library_ = std::make_unique<const Library>(c_source(exported.program, how));
}

void ExportedSolver::fit(const FitInput& input) {
  Frames changes;
  if (precision_ == ExportPrecision::int8) {
    if (!input.validation) {
      throw InputError("exported: int8 is calibrated on the dataset \"validation\"; add it");
    }
    changes =
        input.validation->voltages(0, std::min(int8_calibration_frames, input.validation->size()));
    changes.rowwise() -= input.validation->reference_voltages().transpose();
  }
  compile(input.sensor, changes);
}

void ExportedSolver::reconstruct(FramesView changes, ImagesView images,
                                 std::span<FrameReport>) const {
  // Buffers of the thread, so that a frame allocates nothing.
  thread_local std::vector<double> state;
  thread_local Eigen::RowVectorXf frame;
  thread_local Eigen::RowVectorXf image;
  state.resize(std::max(state.size(), library_->state_numbers()));
  image.resize(images.cols());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    frame = changes.row(f).cast<float>();
    library_->frame(state.data(), frame.data(), image.data());
    images.row(f) = image.cast<double>();
  }
}

void ExportedSolver::save(const fs::path& file) const {
  Hdf5File out = create_solver_file(file, type, sensor_, parameters());
  if (calibration_.size() > 0) out.write_matrix("/calibration", calibration_);
  out.close();
}

void ExportedSolver::load(const fs::path& file, const Sensor& sensor) {
  const Hdf5File in = open_solver_file(file, type, sensor);
  Frames changes;
  if (precision_ == ExportPrecision::int8)
    changes = in.read_rows("/calibration", 0, in.shape("/calibration").front());
  compile(sensor, changes);
}

std::vector<SolverType> exported_solvers(const MakeSolver& make) {
  SolverInfo info;
  info.summary = "a fitted solver as `ertbench export` writes it in C, compiled (docs/robot.md)";
  info.parameters = {
      {"of", "the fitted solver: a file, or a name that `ertbench list --fitted` shows",
       ParameterRole::file},
      {"to", "\"c\""},
      {"precision",
       "of weights: \"float32\" (the default), \"float16\", or \"int8\", calibrated on 200 frames "
       "of the dataset \"validation\""}};
  info.make = [make](JsonObject object) -> std::unique_ptr<Solver> {
    return std::make_unique<ExportedSolver>(std::move(object), make);
  };
  info.probes = {};  // the file of the fitted solver is part of the key
  return {{ExportedSolver::type, info}};
}

}  // namespace ertbench
