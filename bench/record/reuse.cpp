#include "bench/record/reuse.h"

#include <map>

#include "core/build.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {

const char* name_of(Reuse reuse) {
  switch (reuse) {
    case Reuse::same_code:
      return "same-code";
    case Reuse::same_program:
      return "same-program";
    case Reuse::clean:
      return "clean";
  }
  return "";
}

Reuse reuse_from_name(const std::string& name) {
  for (const Reuse reuse : {Reuse::same_code, Reuse::same_program, Reuse::clean}) {
    if (name == name_of(reuse)) return reuse;
  }
  throw InputError("--reuse: must be same-code, same-program or clean, got \"" + printable(name) +
                   "\"");
}

std::string why_stale(const std::optional<BuildStamp>& made, const BuildStamp& now, Reuse reuse) {
  if (!made) return "it does not say which build made it";
  const std::string by = " (commit " + made->commit_text() + ")";
  if (made->code != now.code || made->plugins != now.plugins) {
    return "it was made by other code" + by;
  }
  if (made->program == now.program) return "";
  if (reuse == Reuse::same_program) {
    return "it was made by another program" + by;
  }
  if (reuse == Reuse::clean && (made->dirty || made->commit == "unknown")) {
    return "it was made by a build whose sources were not committed" + by;
  }
  return "";
}

std::string fit_code_now(const std::string& code) {
  const std::map<std::string, std::string>& codes = this_build().fit_codes;
  const auto found = codes.find(code.substr(0, code.find(' ')));
  return found == codes.end() ? "" : found->second;
}

}  // namespace ertbench
