#include "core/process_tree.h"

#include <dirent.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

namespace ertbench {
namespace {

/// The bytes of a small file of /proc; empty where the process has gone.
std::string text_of(const std::string& file) {
  std::FILE* const in = std::fopen(file.c_str(), "re");
  if (!in) return "";
  char text[1024];
  const std::size_t size = std::fread(text, 1, sizeof text, in);
  std::fclose(in);
  return {text, size};
}

/// 0 where it has gone.
pid_t parent_of(pid_t process) {
  // "12 (any (name)) S 11 ...": what matters begins behind the last bracket.
  const std::string stat = text_of("/proc/" + std::to_string(process) + "/stat");
  const std::size_t bracket = stat.rfind(')');
  if (bracket == std::string::npos || bracket + 4 >= stat.size()) return 0;
  return static_cast<pid_t>(std::strtol(stat.c_str() + bracket + 4, nullptr, 10));
}

std::multimap<pid_t, pid_t> children_by_parent() {
  std::multimap<pid_t, pid_t> children;
  DIR* const folder = ::opendir("/proc");
  if (!folder) return children;
  while (const dirent* entry = ::readdir(folder)) {
    const auto process = static_cast<pid_t>(std::strtol(entry->d_name, nullptr, 10));
    if (process > 0) children.emplace(parent_of(process), process);
  }
  ::closedir(folder);
  return children;
}

std::uint64_t resident_bytes(pid_t process) {
  const std::string statm = text_of("/proc/" + std::to_string(process) + "/statm");
  const std::size_t space = statm.find(' ');
  if (space == std::string::npos) return 0;
  return std::strtoull(statm.c_str() + space, nullptr, 10) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t resident_below(pid_t process, const std::multimap<pid_t, pid_t>& children) {
  std::uint64_t sum = 0;
  const auto [first, last] = children.equal_range(process);
  for (auto one = first; one != last; ++one) {
    sum += resident_bytes(one->second) + resident_below(one->second, children);
  }
  return sum;
}

}  // namespace

std::vector<pid_t> children_of(pid_t process) {
  std::vector<pid_t> out;
  const std::multimap<pid_t, pid_t> all = children_by_parent();
  const auto [first, last] = all.equal_range(process);
  for (auto one = first; one != last; ++one) out.push_back(one->second);
  return out;
}

std::uint64_t resident_bytes_below(pid_t process) {
  return resident_below(process, children_by_parent());
}

}  // namespace ertbench
