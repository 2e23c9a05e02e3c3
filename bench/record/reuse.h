#pragma once

#include <optional>
#include <string>

#include "core/build_stamp.h"

namespace ertbench {

/// Which datasets, fitted solvers and records of earlier runs are taken as they are. In every case
/// their recipe, their keys, must be the same.
enum class Reuse {
  same_code,     ///< those whose numbers do not depend on anything that changed since
  same_program,  ///< those of this very program (`--rebuild-stale`)
  clean,         ///< those of the same code from builds whose sources were committed (`publish`)
};

/// "same-code", "same-program", "clean": of `ertbench trial --reuse`.
const char* name_of(Reuse reuse);
/// The inverse. Throws InputError for another name.
Reuse reuse_from_name(const std::string& name);

/// Why something is not to be reused, "it was made by other code (commit 0123456789ab)"; empty
/// where it may be. `made`: the build that made it, none where it does not say; `now`: this one,
/// with the hash of the code that such things depend on.
std::string why_stale(const std::optional<BuildStamp>& made, const BuildStamp& now, Reuse reuse);

/// The code (Build::fit_codes) that a fitted solver has now, of whose room `code` was when it was
/// fitted; empty where there is no such room any more.
std::string fit_code_now(const std::string& code);

}  // namespace ertbench
