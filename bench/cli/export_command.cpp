#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>

#include "bench/cli/command.h"
#include "bench/score/image_contacts.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/check/stored_solver.h"
#include "solvers/export/exported_solver.h"
#include "solvers/export/matrix_files.h"
#include "solvers/export/onnx_file.h"
#include "solvers/export/runtime_file.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct ExportArguments {
  std::string solver;
  std::string to = "c";
  std::string precision = "float32";
  std::string frames;
  std::uint64_t check_frames = 0;
  bool front = false;
  std::string out;
  ContactSettings contacts;
};

using Files = std::map<std::string, std::string>;

/// By words that stand in what an export writes.
bool is_exported(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  const char* const mark = ending == ".npz"   ? "reference_voltages.npy"
                           : ending == ".csv" ? ","
                           : ending == ".ert" ? "ERTRUN"
                                              : "ertbench export";
  return contents_of(file).find(mark) != std::string::npos;
}

/// The rule that an experiment would choose on the same frames, or its defaults.
ExportedRule rule_of(const ExportArguments& arguments, const SolverToExport& exported,
                     const DatasetFile* frames) {
  const ContactRule rule =
      choose_contact_rule(arguments.contacts, exported.sensor, *exported.solver, frames).rule;
  return {rule.threshold, rule.floor, rule.saddle};
}

Files c_files(const ExportArguments& arguments, SolverToExport& exported,
              const DatasetFile* frames) {
  CExport how{.name = arguments.solver,
              .sensor = exported.sensor,
              .precision = precision_from_name(arguments.precision),
              .rule = rule_of(arguments, exported, frames),
              .front = exported.front};
  if (how.precision == ExportPrecision::int8) {
    if (!frames) {
      throw InputError(
          "--precision int8 is calibrated on frames: name a dataset file with --frames, such as "
          "`ertbench generate EXPERIMENT.json --dataset validation --out FILE` writes");
    }
    Frames changes = frames->voltages(0, std::min(int8_calibration_frames, frames->size()));
    changes.rowwise() -= frames->reference_voltages().transpose();
    how.ranges = calibrate(exported, std::move(changes));
  }
  return c_source(exported.program, how);
}

Files runtime_files(const ExportArguments& arguments, const SolverToExport& exported,
                    const DatasetFile* frames) {
  return runtime_file(exported.layers, {.name = arguments.solver,
                                        .sensor = exported.sensor,
                                        .rule = rule_of(arguments, exported, frames),
                                        .front = exported.front});
}

Files files_of(const ExportArguments& arguments, SolverToExport& exported,
               const DatasetFile* frames) {
  const std::string& to = arguments.to;
  if (to == "c") return c_files(arguments, exported, frames);
  if (to == "matrix") {
    return matrix_files(exported.program, *exported.solver, exported.sensor,
                        precision_from_name(arguments.precision));
  }
  if (arguments.precision != "float32") {
    throw InputError("--to " + to + " calculates in float32; --to c has float16 and int8");
  }
  if (to == "runtime") return runtime_files(arguments, exported, frames);
  return onnx_file(exported.layers, {.name = arguments.solver, .sensor = exported.sensor});
}

/// The reference and some frames as constants, for a check on the target.
std::string frames_file(const DatasetFile& frames, std::uint64_t count) {
  TextStream text;
  text.precision(9);
  text << "/* Frames, by ertbench export: the reference, then the frames, V. */\n#include "
          "<stdint.h>\n\n"
       << "extern const int32_t ert_frame_count;\nextern const float ert_frames[];\n\n"
       << "const int32_t ert_frame_count = " << count << ";\nconst float ert_frames[] = {\n"
       << std::scientific;
  for (const double voltage : frames.reference_voltages()) text << voltage << "F,\n";
  const Frames voltages = frames.voltages(0, count);
  for (const double voltage : voltages.reshaped<Eigen::RowMajor>()) text << voltage << "F,\n";
  text << "};\n";
  return text.str();
}

ExitCode run_export(const ExportArguments& arguments) {
  SolverRegistry registry;
  registry.allow_plugins();
  const std::filesystem::path file = fitted_file(arguments.solver, "");
  SolverToExport exported = load_to_export(
      file, [&](const JsonObject& entry) { return registry.make(entry); }, arguments.front);
  std::optional<DatasetFile> frames;
  if (!arguments.frames.empty()) {
    frames.emplace(arguments.frames);
    if (frames->sensor() != exported.sensor) {
      throw InputError(arguments.frames + ": is of another sensor than " + file.string());
    }
  }
  const DatasetFile* const given = frames ? &*frames : nullptr;
  Files files;
  try {
    if (exported.front.electrodes > 0 && arguments.to != "c" && arguments.to != "runtime") {
      throw InputError("--to " + arguments.to +
                       " has no front, which finds dead electrodes; take --to c or --to runtime");
    }
    files = files_of(arguments, exported, given);
  } catch (const InputError& error) {
    throw InputError(printable(arguments.solver) + ": " + error.what());
  }
  if (arguments.check_frames > 0) {
    if (!frames || frames->size() < arguments.check_frames) {
      throw InputError("--check-frames: needs --frames with as many");
    }
    files["frames.c"] = frames_file(*frames, arguments.check_frames);
  }
  const std::filesystem::path folder = arguments.out;
  std::error_code refused;  // which the next check says
  std::filesystem::create_directories(folder, refused);
  for (const auto& [name, text] : files) {
    require_output(folder / name, {file, arguments.frames}, {"exported file", is_exported});
  }
  for (const auto& [name, text] : files) {
    write_file_atomically(folder / name, text);
    std::printf("%s\n", printable_path((folder / name).string()).c_str());
  }
  return done;
}

}  // namespace

Action add_export(CLI::App& command) {
  const auto arguments = std::make_shared<ExportArguments>();
  command
      .add_option("SOLVER", arguments->solver,
                  "A fitted solver: a name that `list --fitted` shows, or a file")
      ->required();
  command
      .add_option("--to", arguments->to,
                  "c: solver.h, solver.c, weights.h, weights.c in C99, and example.c (default)\n"
                  "runtime: NAME.ert, which ertbench::runtime loads in a C++ program of your own\n"
                  "onnx: NAME.onnx, for ONNX runtimes\n"
                  "matrix: matrix.npz and matrix.csv of a linear method")
      ->check(CLI::IsMember({"c", "runtime", "onnx", "matrix"}));
  command
      .add_option("--precision", arguments->precision,
                  "Of the weights: float32 (default), float16, or int8 with integers throughout")
      ->check(CLI::IsMember({"float32", "float16", "int8"}));
  command.add_option(
      "--frames", arguments->frames,
      "A dataset file like the frames to come: int8 is calibrated on its first 200,\n"
      "and the rule for contacts chosen on its first 500");
  command.add_flag("--front", arguments->front,
                   "Also find dead electrodes and replace their channels, as the program does;\n"
                   "a network that is told of them always has it");
  command
      .add_option("--threshold", arguments->contacts.threshold,
                  "Of the largest change: what is below is no contact (default: chosen on\n"
                  "--frames, else 0.25)")
      ->check(CLI::Range(0.0, 1.0));
  command
      .add_option("--floor", arguments->contacts.floor,
                  "Of the background: what is below is no contact (default: chosen on\n"
                  "--frames, else 0)")
      ->check(CLI::Range(0.0, 1e6));
  command.add_option("--check-frames", arguments->check_frames,
                     "Also write the first of --frames, this many, as frames.c, to check the code\n"
                     "on the target");
  command.add_option("--out", arguments->out, "Folder of the files")->required();
  command.footer(
      "Example:\n  ertbench export lean-net-8 --out robot\n"
      "  ertbench export lean-net-8 --precision int8 --frames validation.h5 --out robot\n"
      "  ertbench export lean-net-8 --to runtime --out robot\n"
      "  ertbench export lean-net-8 --to onnx --out robot\n"
      "  ertbench export tsvd --to matrix --out robot\n"
      "See docs/robot.md.");
  return [arguments] { return run_export(*arguments); };
}

}  // namespace ertbench
