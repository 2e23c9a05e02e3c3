#include "bench/check/check_folder.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/atomic_file.h"
#include "core/build.h"
#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "core/json_text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* made_by = "ertbench check";

json mark_of(const std::string& program) { return {{"made_by", made_by}, {"program", program}}; }

/// The program that made the folder a check's; nothing where none did, whatever else is there.
std::optional<std::string> marked_program(const fs::path& mark) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(mark, error))) return std::nullopt;
  try {
    const json content = read_json_file(mark);
    JsonObject object(content, mark.string(), "");
    const std::string program = object.text("program");
    return content == mark_of(program) ? std::optional(program) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

std::string program_hash(const std::vector<fs::path>& plugins) {
  return hash_of(to_json(stamp_of_this_build(this_build().record_code, plugins)).dump());
}

Cache prepare_check_folder(const fs::path& folder, const std::string& program) {
  const fs::path mark = folder / ".ertbench-check";
  const fs::path made[] = {folder / "cache", folder / "records", folder / "seeds",
                           folder / "trainings", folder / "networks"};
  const std::optional<std::string> before = marked_program(mark);
  const auto is_there = [](const fs::path& one) { return fs::exists(fs::symlink_status(one)); };
  if (!before && std::any_of(std::begin(made), std::end(made), is_there)) {
    throw InputError(folder.string() +
                     ": holds results that are not a check's (there is no .ertbench-check in it); "
                     "name another folder with --out, remove this one, or take its results as they "
                     "are with --reuse");
  }
  if (before && *before != program) {
    for (const fs::path& one : made) fs::remove_all(one);
  }
  fs::create_directories(folder);
  write_file_atomically(mark, json_text(mark_of(program), 2) + "\n");
  return Cache(folder / "cache");
}

}  // namespace ertbench
