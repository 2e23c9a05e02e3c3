#include "solvers/solver.h"

#include <dlfcn.h>
#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/data/sheet_model.h"
#include "frames/reconstruct.h"
#include "frames/reference_check.h"
#include "python/module/arrays.h"
#include "solvers/check/stored_solver.h"
#include "solvers/registry/registry.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// The built-in solvers and the learned ones, whose library lies beside the core's or, installed,
/// in the folder `ertbench` there.
SolverRegistry& registry() {
  static SolverRegistry solvers = [] {
    SolverRegistry made;
    made.allow_plugins();
    Dl_info core;
    if (dladdr(reinterpret_cast<const void*>(&sensor_from_json), &core) == 0) return made;
    const fs::path folder = fs::canonical(core.dli_fname).parent_path();
    for (const fs::path& beside : {folder, folder / "../bench", folder / "ertbench"}) {
      const fs::path library = beside / "libertbench_models.so";
      if (!fs::exists(library)) continue;
      for (const std::string& type : made.types()) {
        if (made.is_of_plugin(type)) made.add_plugin_type(type, library.lexically_normal());
      }
      break;
    }
    return made;
  }();
  return solvers;
}

/// A solver that is fitted anew without disturbing threads that reconstruct with the old fit.
class PySolver {
 public:
  explicit PySolver(const std::string& text) : text_(text) { make(); }

  void fit(const Sensor& sensor, const std::optional<std::string>& training,
           const std::optional<std::string>& validation, int threads, const py::object& progress) {
    std::unique_ptr<Solver> solver = make();
    solver->check(sensor);
    const Hdf5Turn turn;
    const TemporaryFolder work("python");
    FitInput input;
    input.sensor = sensor;
    std::optional<DatasetFile> sets[2];
    if (training) input.training = &sets[0].emplace(*training);
    if (validation) input.validation = &sets[1].emplace(*validation);
    input.work_folder = work.path();
    input.threads = threads_of(threads);
    input.progress = [&](std::uint64_t done, std::uint64_t total, const std::string& said) {
      const py::gil_scoped_acquire locked;
      check_signals();
      if (!progress.is_none()) progress(done, total, said);
    };
    Eigen::VectorXd reference;
    {
      const py::gil_scoped_release unlocked;
      solver->fit(input);
      reference = input.training ? input.training->reference_voltages() : uniform_reference(sensor);
    }
    take(std::move(solver), sensor, reference);
  }

  void save(const std::string& file) const {
    require_fitted();
    const Hdf5Turn turn;
    require_output(file, {}, {"fitted solver", [](const fs::path& there) {
                                try {
                                  return Hdf5File::open(there).has_attribute("/", "solver");
                                } catch (const InputError&) {
                                  return false;
                                }
                              }});
    replace_file(file, [&](const fs::path& aside) {
      solver_->save(aside);
      Hdf5File out = Hdf5File::open_writable(aside);
      out.write_text("/", "specification", text_);
      if (!out.has("/reference_voltages")) out.write_vector("/reference_voltages", reference_);
      if (out.has_attribute("/", "checksum")) out.write_checksum();
      out.close();
    });
  }

  /// Loads a file that `save` or a run wrote.
  void load(const std::string& file) {
    const Hdf5Turn turn;
    std::optional<Sensor> sensor;
    Eigen::VectorXd reference;
    {
      const Hdf5File in = Hdf5File::open(file);
      sensor = sensor_of(in);
      if (in.has("/reference_voltages")) reference = in.read_vector("/reference_voltages");
    }
    std::unique_ptr<Solver> solver = make();
    solver->load(file, *sensor);
    if (reference.size() != sensor->channels()) reference = uniform_reference(*sensor);
    take(std::move(solver), *sensor, reference);
  }

  py::tuple reconstruct(const py::object& frames, const py::object& reference, int threads) const {
    require_fitted();
    const std::shared_ptr<const Solver> solver = solver_;  // the fit of now
    const Rows rows = changes_of(frames);
    const Eigen::RowVectorXd zero = reference_of(frames, reference);
    const Eigen::Index pixels = sensor_.pixels();
    Array images = rows.make({sensor_.image_rows(), sensor_.image_columns()});
    std::vector<FrameReport> reports(static_cast<std::size_t>(rows.count));
    Eigen::Map<Images> out(images.mutable_data(), rows.count, pixels);
    // The program's own blocks, so that images are the same to the bit.
    const Eigen::Index block = solver->block_frames() > 0 ? solver->block_frames() : 16;
    for_blocks(rows.count, block, threads, [&](auto begin, auto end) {
      const Eigen::Index count = end - begin;
      Frames changes = rows.view().middleRows(begin, count);
      if (zero.size() > 0) changes.rowwise() -= zero;
      solver->reconstruct(
          changes, out.middleRows(begin, count),
          {&reports[static_cast<std::size_t>(begin)], static_cast<std::size_t>(count)});
    });
    return py::make_tuple(images, statuses(rows, out, reports));
  }

  /// [N, 8, 6] as in the files of `ertbench reconstruct`, NaN where there is no contact.
  Array contacts(const py::object& frames, const py::object& reference, int threads) const {
    require_fitted();
    const std::shared_ptr<const Solver> solver = solver_;
    const ContactFinder* const finder = solver->contact_finder();
    if (!finder) {
      throw InputError(
          "contacts: this solver makes images alone; \"contacts\" and "
          "\"kernel-ridge\" find contacts themselves");
    }
    const Rows rows = changes_of(frames);
    const Eigen::RowVectorXd zero = reference_of(frames, reference);
    Array out = rows.make({written_contacts[0], written_contacts[1]});
    Eigen::Map<RowMajorMatrix> table(out.mutable_data(), rows.count,
                                     written_contacts[0] * written_contacts[1]);
    const std::vector<Eigen::Matrix2d> twins = twin_symmetries(sensor_);
    for_blocks(rows.count, 16, threads, [&](auto begin, auto end) {
      Frames changes = rows.view().middleRows(begin, end - begin);
      if (zero.size() > 0) changes.rowwise() -= zero;
      table.middleRows(begin, end - begin) = contacts_of(*finder, sensor_, twins, changes);
    });
    return out;
  }

  std::string specification() const { return text_; }
  std::string parameters() const {
    return json_text(solver_ ? solver_->parameters() : make()->parameters());
  }
  py::object sensor() const { return solver_ ? py::cast(sensor_) : py::none(); }
  Array reference() const {
    require_fitted();
    return array_of(reference_.transpose(), {reference_.size()});
  }
  std::string report() const {
    const FitReport report = solver_ ? solver_->fit_report() : FitReport{};
    return report.status == "ok" ? "" : report.status + ": " + report.message;
  }

 private:
  std::unique_ptr<Solver> make() const {
    const nlohmann::json spec = parse_json(text_, "Solver");
    return registry().make(JsonObject(spec, "Solver", ""));
  }

  void take(std::unique_ptr<Solver> solver, const Sensor& sensor,
            const Eigen::VectorXd& reference) {
    solver_ = std::move(solver);
    sensor_ = sensor;
    reference_ = reference;
  }

  void require_fitted() const {
    if (!solver_) throw InputError("Solver: is not fitted; call fit first, or load a fitted one");
  }

  /// Frames as they came, or the changes of an object that knows them (Frames of a file).
  Rows changes_of(const py::object& frames) const {
    const bool knows = !py::isinstance<py::array>(frames) && py::hasattr(frames, "changes");
    const py::object array = knows ? frames.attr("changes") : frames;
    const py::object own = knows ? py::getattr(frames, "sensor", py::none()) : py::none();
    if (py::isinstance<Sensor>(own) && own.cast<const Sensor&>() != sensor_) {
      throw InputError(
          "frames: are of another sensor than the solver was fitted for; fit one for "
          "`frames.sensor`, or read the frames with `solver.sensor`");
    }
    // A frame with a number that is not finite has the status "undefined".
    return rows_of(array, "frames", {sensor_.channels()}, "V", false);
  }

  /// What to subtract from each frame; empty for nothing.
  Eigen::RowVectorXd reference_of(const py::object& frames, const py::object& given) const {
    const bool knows = !py::isinstance<py::array>(frames) && py::hasattr(frames, "changes");
    if (given.is_none()) return knows ? Eigen::RowVectorXd() : reference_.transpose();
    if (knows) {
      throw InputError("reference: these frames have their own; pass their .voltages as well");
    }
    const Array numbers = numbers_of(given, "reference");
    if (numbers.ndim() == 0 && *numbers.data() == 0) return {};
    const Rows rows = rows_of(numbers, "reference", {sensor_.channels()}, "V", false);
    if (!rows.single) {
      throw InputError("reference: must be one frame [" + std::to_string(sensor_.channels()) +
                       "] (V), or 0 where the frames are changes; got " + shape_text(numbers));
    }
    return filled_reference(sensor_, rows.view().row(0).transpose(),
                            BorderModel(sensor_).reference_voltages())
        .transpose();
  }

  static py::object statuses(const Rows& rows, Eigen::Map<Images>& images,
                             const std::vector<FrameReport>& reports) {
    const auto status_of = [&](Eigen::Index i) {
      FrameStatus status = reports[static_cast<std::size_t>(i)].status;
      if (!images.row(i).allFinite()) status = FrameStatus::undefined;
      if (status == FrameStatus::undefined) images.row(i).setConstant(std::nan(""));
      return static_cast<std::uint8_t>(status);
    };
    if (rows.single) return py::int_(status_of(0));
    py::array_t<std::uint8_t> out(rows.count);
    for (Eigen::Index i = 0; i < rows.count; ++i) out.mutable_at(i) = status_of(i);
    return out;
  }

  std::string text_;  ///< JSON: an entry of an experiment's "solvers"
  std::shared_ptr<const Solver> solver_;
  Sensor sensor_;
  Eigen::VectorXd reference_;
};

py::dict solver_types() {
  py::dict out;
  for (const std::string& type : registry().types()) {
    const SolverInfo* info = registry().find_known(type);
    py::dict parameters;
    if (info) {
      for (const ParameterInfo& one : info->parameters) {
        parameters[py::str(one.name)] = one.description;
      }
    }
    out[py::str(type)] = py::make_tuple(info ? info->summary : "a learned solver", parameters);
  }
  return out;
}

/// Type, parameters of the fit and, where Python wrote it, the whole specification of a solver
/// file.
std::string specification_of(const std::string& file) {
  const Hdf5Turn turn;
  const Hdf5File in = Hdf5File::open(file);
  if (!in.has_attribute("/", "solver")) {
    throw InputError(file + ": is no fitted solver; those that Solver.save and a run write are");
  }
  if (in.has_attribute("/", "specification")) return in.read_text("/", "specification");
  nlohmann::json spec =
      in.has_attribute("/", "parameters") ? parameters_of_fit(in) : nlohmann::json::object();
  spec["type"] = in.read_text("/", "solver");
  return json_text(spec);
}

}  // namespace

void bind_solver(py::module_& module) {
  module.def("solver_types", &solver_types);
  module.def("specification_of", &specification_of);
  module.def(
      "fitted_file",
      [](const std::string& word, const std::string& folder) {
        return fitted_file(word, folder).string();
      },
      py::arg("file_or_name"), py::arg("folder") = "");
  py::class_<PySolver>(module, "Solver")
      .def(py::init<const std::string&>())
      .def("_fit", &PySolver::fit)
      .def("_save", &PySolver::save)
      .def("_load", &PySolver::load)
      .def("_contacts", &PySolver::contacts)
      .def(
          "reconstruct", &PySolver::reconstruct, py::arg("frames"),
          py::arg("reference") = py::none(), py::arg("threads") = 0,
          "Images of frames: (images, status).\n\n"
          "frames: [N, channels] V, or one frame [channels]; or the frames of `read_frames` or of\n"
          "`Scenes.draw`, which know their own reference.\n"
          "reference: [channels] V of the sheet without contact; by default that of the fit, see\n"
          "`Solver.reference`. 0 where `frames` are changes already.\n"
          "threads: how many to use for many frames; 0: $ERTBENCH_THREADS, else all cores.\n\n"
          "images: [N, rows, columns] S/m, the change of the conductivity; row 0 at the least y.\n"
          "status: [N] uint8: 0 ok, 1 not converged (has an image), 2 undefined (its image is "
          "NaN),\n"
          "3 suspect (has an image, but the frame is not to be trusted).\n"
          "Of one frame: one image and one number. Several threads may share a solver.")
      .def_property_readonly("_specification", &PySolver::specification)
      .def_property_readonly("_parameters", &PySolver::parameters)
      .def_property_readonly("_sensor", &PySolver::sensor)
      .def_property_readonly("_report", &PySolver::report)
      .def_property_readonly(
          "reference", &PySolver::reference,
          "Voltages that frames are compared with by default, [channels] V: those\n"
          "of the training set or, without one, of the model.");
}

}  // namespace ertbench
