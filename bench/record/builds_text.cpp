#include "bench/record/builds_text.h"

#include <nlohmann/json.hpp>

namespace ertbench {

std::string text_of(const Builds& builds) {
  std::map<std::string, std::string> made;  // what each build made
  bool dirty = false;
  for (const auto& [stage, stamps] : builds) {
    for (const BuildStamp& stamp : stamps) {
      std::string& what =
          made["commit " + stamp.commit_text() + ", program " + stamp.program.substr(0, 8)];
      what += (what.empty() ? "" : ", ") + stage;
      dirty = dirty || stamp.dirty;
    }
  }
  if (made.empty()) return "";
  std::string out;
  if (made.size() == 1) {
    out = "build: " + made.begin()->first + ".";
  } else {
    out = "Made of records of " + std::to_string(made.size()) +
          " builds of the program, whose code does not differ in what the numbers depend on:";
    for (const auto& [build, what] : made)
      out.append(" ").append(build).append(" (").append(what).append(");");
    out.back() = '.';
  }
  if (dirty) out += " dirty: with changes that were not committed.";
  return out;
}

nlohmann::json to_json(const Builds& builds) {
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [stage, stamps] : builds) {
    for (const BuildStamp& stamp : stamps) out[stage].push_back(to_json(stamp));
  }
  return out;
}

}  // namespace ertbench
