#include "solvers/external/command_solver.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "core/errors.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/sheet_model.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Reads or writes so many bytes; false if that fails or ends too early.
template <typename Byte>
bool move_whole(auto&& call, int descriptor, Byte* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t some = call(descriptor, bytes, count);
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) return false;
    bytes += some;
    count -= static_cast<std::size_t>(some);
  }
  return true;
}

/// Body of the echo process.
void answer_frames(std::size_t channels, std::size_t pixels) {
  std::vector<double> frames;
  std::vector<char> images;
  std::uint64_t count = 0;
  const auto read = [](auto* to, std::size_t bytes) {
    return move_whole(::read, STDIN_FILENO, reinterpret_cast<char*>(to), bytes);
  };
  while (read(&count, sizeof count)) {
    frames.resize(count * channels);
    images.resize(count * (pixels * sizeof(double) + 1));
    if (!read(frames.data(), frames.size() * sizeof(double))) return;
    if (!move_whole(::write, STDOUT_FILENO, images.data(), images.size())) return;
  }
}

class EchoSolver final : public Solver {
 public:
  explicit EchoSolver(const Sensor& sensor)
      : program_(
            "echo",
            [channels = static_cast<std::size_t>(sensor.channels()),
             pixels = static_cast<std::size_t>(sensor.pixels())] {
              answer_frames(channels, pixels);
              ::_exit(
                  0);  // a copy of this process: what else it is to do at its end is not its own
            },
            0),
        exchange_(program_, limit_s) {}

  nlohmann::json parameters() const override { return nlohmann::json::object(); }
  void fit(const FitInput&) override {}
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override {
    exchange_.reconstruct(changes, images, reports);
  }
  void save(const std::filesystem::path&) const override {
    throw std::logic_error("the echo of frames is not kept");
  }
  void load(const std::filesystem::path&, const Sensor&) override {
    throw std::logic_error("the echo of frames is not kept");
  }

 private:
  static constexpr double limit_s = 10;

  Program program_;
  mutable FrameExchange exchange_;
};

constexpr const char* request_name = "/request";
constexpr std::size_t most_line_bytes = 1 << 20;
constexpr std::size_t most_words = 1000;
/// Longest error message, in characters, that is taken from a program.
constexpr std::size_t most_error_text = 1000;

std::vector<std::string> words_of(JsonObject& object, const char* key) {
  const json& words = object.raw(key);
  const bool good =
      words.is_array() && !words.empty() && words.size() <= most_words &&
      std::all_of(words.begin(), words.end(), [](const json& one) {
        return one.is_string() && one.get_ref<const std::string&>().find('\0') == std::string::npos;
      });
  if (!good) {
    object.fail(
        key, "must be a list of words, [\"python3\", \"my_method.py\"], got " + json_shown(words));
  }
  return words.get<std::vector<std::string>>();
}

/// Environment variables that set the numbers of threads of libraries.
constexpr const char* thread_variables[] = {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS",
                                            "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"};

[[noreturn]] void become_program(const std::vector<std::string>& command, const fs::path& folder,
                                 int threads) {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  for (const char* variable : thread_variables) {
    ::setenv(variable, std::to_string(threads).c_str(), 1);
  }
  if (::chdir(folder.c_str()) == 0) ::execvp(words[0], words.data());
  const char* const why = std::strerror(errno);
  if (::write(STDERR_FILENO, why, std::strlen(why)) < 0) ::_exit(126);
  ::_exit(ChildProcess::not_started);
}

json path_or_null(const DatasetFile* set) {
  return set ? json(fs::absolute(set->path()).string()) : json(nullptr);
}

/// Converts paths to or from paths relative to a folder.
void change_paths(json& request, const std::function<fs::path(const fs::path&)>& change) {
  for (const char* key : {"train", "validation", "work_folder"}) {
    if (request.at(key).is_string()) {
      request[key] = change(request.at(key).get<std::string>()).string();
    }
  }
}

/// False also for words that cannot be a file name, such as overlong ones.
bool is_file(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

}  // namespace

std::unique_ptr<Solver> echo_solver(const Sensor& sensor) {
  return std::make_unique<EchoSolver>(sensor);
}

CommandSolver::CommandSolver(JsonObject object)
    : command_(words_of(object, "command")),
      given_(json::object()),
      protocol_(object.integer_or("protocol", 1, 1, 2)),
      ready_limit_s_(object.number_or("ready_limit_s", 3600, {0, 1e7, true, "s"})),
      frame_limit_s_(object.number_or("frame_limit_s", 10, {0, 1e7, true, "s"})),
      memory_limit_mb_(object.has("memory_limit_mb") ? object.number("memory_limit_mb", {1, 1e9})
                                                     : 0),
      folder_(object.folder()) {
  if (object.has("files")) {
    files_ = words_of(object, "files");
    for (const json& file : files_) {
      if (!is_file(folder_ / file.get<std::string>())) {
        object.fail("files", printable_path(file.get<std::string>()) + " is no file in " +
                                 printable_path(folder_.string()));
      }
    }
  }
  if (object.has("seed")) seed_ = object.integer("seed", 0, std::numeric_limits<int>::max());
  if (object.has("parameters")) {
    given_ = object.raw("parameters");
    if (!given_.is_object())
      object.fail("parameters", "must be an object, got " + json_shown(given_));
  }
  name_ = one_line(fs::path(command_.front()).filename().string(), 40);
  const auto script =
      std::find_if(command_.begin() + 1, command_.end(),
                   [this](const std::string& word) { return is_file(folder_ / word); });
  if (script != command_.end()) {
    name_ += " " + one_line(fs::path(*script).filename().string(), 60);
  }
  const fs::path program = command_.front();
  if (program.empty()) object.fail("command", "its first word, the program, is empty");
  if (program.has_parent_path() && !is_file(folder_ / program)) {
    object.fail("command", printable_path(program.string()) + " is no program in " +
                               printable_path(folder_.string()));
  }
  object.finish();
}

json CommandSolver::parameters() const {
  json out = {{"command", command_},
              {"parameters", used_.is_object() ? used_ : given_},
              {"ready_limit_s", ready_limit_s_},
              {"frame_limit_s", frame_limit_s_}};
  if (!files_.is_null()) out["files"] = files_;
  if (protocol_ > 1) out["protocol"] = protocol_;
  if (seed_) out["seed"] = *seed_;
  if (memory_limit_mb_ > 0) out["memory_limit_mb"] = memory_limit_mb_;
  return out;
}

void CommandSolver::fit(const FitInput& input) {
  const Sensor& sensor = input.sensor;
  const DatasetFile* const set = input.training ? input.training : input.validation;
  const Eigen::VectorXd reference = set ? set->reference_voltages() : uniform_reference(sensor);
  request_ = {{"protocol", protocol_},
              {"sensor", to_json(sensor)},
              {"channels", sensor.channels()},
              {"image", {sensor.image_rows(), sensor.image_columns()}},
              {"background", sensor.background},
              {"reference_voltages", std::vector<double>(reference.begin(), reference.end())},
              {"train", path_or_null(input.training)},
              {"validation", path_or_null(input.validation)},
              {"parameters", given_},
              {"work_folder", work_folder(input).string()},
              {"threads", input.threads}};
  if (seed_) request_["seed"] = *seed_;
  start(sensor);
}

fs::path CommandSolver::work_folder(const FitInput& input) {
  if (!input.work_folder.empty()) {
    passing_folder_.reset();
    return fs::absolute(input.work_folder);
  }
  return passing_folder_.emplace("command").path();
}

void CommandSolver::start(const Sensor& sensor) {
  exchange_.reset();
  program_.reset();
  sensor_ = sensor;
  program_ = std::make_unique<Program>(
      name_, [this] { become_program(command_, folder_, request_.at("threads").get<int>()); },
      static_cast<std::uint64_t>(memory_limit_mb_ * (1 << 20)));
  fresh_.reset();
  program_->send(json_text(request_) + "\n", ready_limit_s_);
  json said = answer();
  while (protocol_ > 1 && said.contains("scenes")) {
    send_scenes(said.at("scenes"));
    said = answer();
  }
  used_ = said.value("parameters", given_);
  if (!used_.is_object()) used_ = given_;
  fresh_.reset();
  exchange_ = std::make_unique<FrameExchange>(*program_, frame_limit_s_);
}

json CommandSolver::answer() {
  const std::string line = program_->line(ready_limit_s_, most_line_bytes);
  json said;
  try {
    said = parse_json(line, "its first line");
  } catch (const InputError&) {
  }
  if (said.is_object() && said.contains("error")) {
    const json& error = said.at("error");
    throw FailedTrial("failed",
                      name_ + ": says: " +
                          printable(error.is_string() ? error.get<std::string>() : json_text(error),
                                    most_error_text));
  }
  const bool asks = protocol_ > 1 && said.is_object() && said.contains("scenes");
  if (!asks && (!said.is_object() || !said.contains("ready") || said.at("ready") != true)) {
    const bool ahead = said.is_object() && said.contains("scenes");
    throw FailedTrial("failed", name_ +
                                    ": its first line must be {\"ready\": true, "
                                    "\"parameters\": {...}} or {\"error\": \"...\"}, got «" +
                                    printable(line, 80) + "»" +
                                    (ahead ? "; scenes need \"protocol\": 2 in its row" : ""));
  }
  return said;
}

void CommandSolver::send_scenes(const json& count) {
  constexpr std::uint64_t most = 1 << 16;
  if (!count.is_number_unsigned() || count == 0 || count > most) {
    throw FailedTrial("failed", name_ + ": \"scenes\" must be 1 to " + std::to_string(most) +
                                    " at a time, got " + json_shown(count));
  }
  const json& train = request_.at("train");
  if (!train.is_string()) {
    throw FailedTrial("failed", name_ + ": asks for scenes, but there is no /datasets/train");
  }
  if (!fresh_) {
    fresh_.emplace(DatasetFile(train.get<std::string>()), seed_.value_or(1),
                   request_.at("threads").get<int>());
  }
  const FreshScenes::Block block = fresh_->next(count);
  for (const RowMajorMatrix* rows : {&block.changes, &block.image_changes}) {
    program_->send({reinterpret_cast<const char*>(rows->data()),
                    static_cast<std::size_t>(rows->size()) * sizeof(double)},
                   ready_limit_s_);
  }
}

void CommandSolver::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) const {
  exchange_->reconstruct(changes, images, reports);
}

std::unique_ptr<Solver> CommandSolver::transport() const { return echo_solver(sensor_); }

void CommandSolver::save(const fs::path& file) const {
  const fs::path folder = fs::absolute(file).parent_path();
  json request = request_;
  if (passing_folder_) request["work_folder"] = nullptr;
  change_paths(request, [&](const fs::path& path) { return path.lexically_proximate(folder); });
  Hdf5File out = create_solver_file(file, type, sensor_, parameters());
  out.write_text_dataset(request_name, json_text(request));
  out.close();
}

void CommandSolver::load(const fs::path& file, const Sensor& sensor) {
  const fs::path folder = fs::absolute(file).parent_path();
  {
    const Hdf5File in = open_solver_file(file, type, sensor);
    request_ = parse_json(in.read_text_dataset(request_name), file.string() + ": " + request_name);
  }
  try {
    change_paths(request_,
                 [&](const fs::path& path) { return (folder / path).lexically_normal(); });
    for (const char* key : {"train", "validation"}) {
      if (request_.at(key).is_string() && !fs::exists(request_.at(key).get<std::string>())) {
        request_[key] = nullptr;
      }
    }
    request_["threads"] = 1;
    passing_folder_.reset();
    if (request_.at("work_folder").is_null()) {
      request_["work_folder"] = passing_folder_.emplace("command").path().string();
    }
    fs::create_directories(request_.at("work_folder").get<std::string>());
  } catch (const json::exception&) {
    throw InputError(file.string() + ": " + request_name +
                     " is not what a program is told; fit the solver anew");
  }
  start(sensor);
}

std::vector<SolverType> external_solvers() {
  SolverInfo info;
  info.summary =
      "a program of any language in a process of its own: a line of JSON in, then frames in and "
      "images out (docs/your_method.md)";
  info.parameters = {
      {"command",
       "the program and its arguments, [\"python3\", \"my_method.py\"]; it runs in the "
       "experiment's folder, and what is in the files among these words is part of the fit",
       ParameterRole::file},
      {"files", "further files whose contents are part of the fit; default none",
       ParameterRole::file},
      {"parameters", "an object that the program gets as it is; default {}"},
      {"protocol", "2 for a program that asks for fresh scenes while it fits; default 1"},
      {"seed", "that the program gets, 0 ... 2147483647; default none", ParameterRole::seed},
      {"ready_limit_s", "until it is ready, or asks for scenes, > 0; default 3600"},
      {"frame_limit_s", "for each frame, > 0; default 10"},
      {"memory_limit_mb", "of all its processes, 1 ...; default that of the trial"}};
  info.make = make_from_json<CommandSolver>;
  info.probes = {};  // its files are part of the key, its protocol has a version
  // The program's libraries are unknown; its images are compared up to rounding.
  info.comparison = ImageComparison::rounding;
  return {{CommandSolver::type, info}};
}

}  // namespace ertbench
