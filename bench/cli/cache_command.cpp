#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "bench/cli/command.h"
#include "bench/record/cache_contents.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

struct CacheArguments {
  bool prune = false;
  bool all = false;
  bool stale = false;
  bool dry_run = false;
  std::optional<double> older_than;
};

std::string megabytes(std::uint64_t bytes) {
  return fixed(static_cast<double>(bytes) / (1 << 20), 1) + " MB";
}

bool is_chosen(const CachedThing& thing, const CacheArguments& arguments) {
  if (thing.in_use) return false;
  return arguments.all || (arguments.stale && thing.stale) ||
         (arguments.older_than && thing.age_days > *arguments.older_than);
}

std::string line_of(const CachedThing& thing) {
  return thing.kind + "  " + printable_path(thing.file.filename().string()) + "  " +
         megabytes(thing.bytes) + ", " + fixed(thing.age_days, 1) + " days old, commit " +
         printable(thing.commit) + (thing.stale ? ", of other code: made again when needed" : "") +
         (thing.in_use ? ", in use" : "");
}

ExitCode cache(const CacheArguments& arguments) {
  const Cache cache = Cache::standard();
  if (arguments.prune && !arguments.all && !arguments.stale && !arguments.older_than) {
    throw InputError("--prune: say what: --stale, --older-than DAYS, or --all");
  }
  std::uint64_t bytes = 0;
  std::size_t count = 0;
  for (const CachedThing& thing : cache_contents(cache)) {
    if (arguments.prune && !is_chosen(thing, arguments)) continue;
    if (arguments.prune && !arguments.dry_run) remove_cached(thing);
    std::printf("%s\n", line_of(thing).c_str());
    bytes += thing.bytes;
    ++count;
  }
  const char* what = !arguments.prune ? "" : arguments.dry_run ? " would be removed" : " removed";
  std::printf("%s: %zu datasets and solvers%s, %s\n",
              printable_path(cache.folder().string()).c_str(), count, what,
              megabytes(bytes).c_str());
  return done;
}

}  // namespace

Action add_cache(CLI::App& command) {
  const auto arguments = std::make_shared<CacheArguments>();
  command.description("List the datasets and fitted solvers that are kept, or remove some");
  CLI::Option* prune = command.add_flag("--prune", arguments->prune,
                                        "Remove what the other options choose, but for what is\n"
                                        "in use; the next run makes again what it needs");
  command.add_flag("--stale", arguments->stale, "Of other code than this program's")->needs(prune);
  command.add_option("--older-than", arguments->older_than, "Written so many days ago")
      ->check(CLI::Range(0.0, 1e6))
      ->needs(prune);
  command.add_flag("--all", arguments->all, "All of it")->needs(prune);
  command.add_flag("--dry-run", arguments->dry_run, "Only say what would be removed")->needs(prune);
  command.footer(
      "Example:\n  ertbench cache --prune --stale --older-than 30\n"
      "The cache is the folder cache/ of the project, or $ERTBENCH_CACHE. Whatever is in it can\n"
      "be made again; a training may take hours.");
  return [arguments] { return cache(*arguments); };
}

}  // namespace ertbench
