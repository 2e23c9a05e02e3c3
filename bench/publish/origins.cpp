#include "bench/publish/origins.h"

#include <nlohmann/json.hpp>
#include <set>

#include "bench/publish/published_folder.h"
#include "core/json.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* dash = "—";

std::string joined(const std::set<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out.empty() ? dash : out;
}

/// What a key of the builds of a result says, each once: "commit" or "code".
std::set<std::string> said(const json& builds, const std::string& what, const std::string& key) {
  std::set<std::string> out;
  if (!builds.contains(what)) return out;
  for (const json& build : builds.at(what)) out.insert(build.value(key, ""));
  return out;
}

/// The first digits of the hash of the networks' code among those of all fits.
std::set<std::string> codes_of_networks(const json& builds) {
  constexpr std::string_view room = "models ";
  std::set<std::string> codes;
  for (const std::string& code : said(builds, "fits", "code")) {
    if (code.starts_with(room)) codes.insert(code.substr(room.size(), 8));
  }
  return codes;
}

/// The commits that made its numbers; of a result that does not say, that of the program that wrote
/// it.
std::string commits_of(const json& summary) {
  std::set<std::string> commits;
  const json builds = summary.value("builds", json::object());
  for (const auto& [what, made] : builds.items()) {
    if (what != "timing") commits.merge(said(builds, what, "commit"));
  }
  if (commits.empty()) commits.insert(summary.at("provenance").value("commit", dash));
  return joined(commits);
}

std::set<std::string> codes_of_scores(const json& builds) {
  std::set<std::string> codes;
  for (const auto& [what, made] : builds.items()) {
    if (what == "timing" || what == "fits") continue;
    for (const std::string& code : said(builds, what, "code")) codes.insert(code.substr(0, 8));
  }
  return codes;
}

/// " Scores: all that say it are of one code, 01234567."
std::string sameness(const std::string& what, const std::set<std::string>& codes) {
  if (codes.empty()) return "";
  const std::string said =
      codes.size() == 1 ? ": all that say it are of one code, " : ": they are of different codes, ";
  return " " + what + said + joined(codes) + ".";
}

/// Processor and day of the rows' times.
std::vector<std::string> clocks_of(const json& summary) {
  std::set<std::string> processors;
  bool timed = false;
  for (const json& row : summary.value("rows", json::array())) {
    const bool of_load = row.contains("service_us");
    if (!of_load && row.value("latency_us", json()).is_null()) continue;
    timed = true;
    if (row.contains("timed_on")) processors.insert(row.at("timed_on").value("cpu", ""));
  }
  if (!timed) return {dash, dash};
  if (processors.empty()) processors.insert(summary.at("provenance").value("cpu", dash));
  const json taken = summary.value("clocks", summary.at("provenance"));
  return {taken.value("date", dash).substr(0, 10), joined(processors)};
}

/// summary.json; of a comparison of the sheet's models and of rates of frames, which have none, the
/// like of it; else null.
json origin_of(const fs::path& folder) {
  if (fs::exists(folder / "summary.json")) return read_json_file(folder / "summary.json");
  const fs::path provenance = folder / "provenance.json";
  if (fs::exists(provenance)) {
    const json read = read_json_file(provenance);
    return {{"provenance", read}, {"builds", read.value("builds", json::object())}};
  }
  const fs::path load = folder / "load.json";
  return fs::exists(load) ? read_json_file(load) : json();
}

}  // namespace

Table origins_table(const fs::path& published) {
  Table table;
  table.title = "What made each result";
  table.text =
      "Numbers of the same code are the numbers of one program, whatever commit it was built of: "
      "the hashes are over all sources that scores, and trainings of networks, depend on. \"—\": "
      "there is none, or the result is from before results said it. Times may have been taken "
      "later than all else, and on another machine (publish --clocks).";
  TableSection& section = table.sections.emplace_back();
  for (const char* title : {"result", "commits", "code of scores", "code of networks", "measured",
                            "on", "times taken", "on"}) {
    section.columns.push_back({title, Align::left});
  }
  std::set<std::string> all_scores;
  std::set<std::string> all_networks;
  for (const fs::path& folder : published_folders(published)) {
    const json summary = origin_of(folder);
    if (summary.is_null()) continue;
    const json& provenance = summary.at("provenance");
    const json builds = summary.value("builds", json::object());
    const std::vector<std::string> clocks = clocks_of(summary);
    const std::set<std::string> scores = codes_of_scores(builds);
    const std::set<std::string> networks = codes_of_networks(builds);
    all_scores.insert(scores.begin(), scores.end());
    all_networks.insert(networks.begin(), networks.end());
    section.rows.push_back({folder.filename().string(), commits_of(summary), joined(scores),
                            joined(networks), provenance.value("date", dash).substr(0, 10),
                            provenance.value("cpu", dash), clocks.at(0), clocks.at(1)});
  }
  table.text += sameness("Scores", all_scores) + sameness("Networks", all_networks);
  return table;
}

}  // namespace ertbench
