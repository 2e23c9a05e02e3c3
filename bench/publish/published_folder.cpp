#include "bench/publish/published_folder.h"

#include <algorithm>

#include "bench/pages/page.h"

namespace ertbench {

namespace fs = std::filesystem;

std::vector<fs::path> published_folders(const fs::path& published) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(published)) {
    const std::string ending = entry.path().extension().string();
    if (ending == part_ending || ending == before_ending) continue;
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

fs::path part_of(const fs::path& folder) {
  fs::path part = folder;
  part += part_ending;
  fs::remove_all(part);
  fs::create_directories(part);
  return part;
}

fs::path copied_part_of(const fs::path& folder) {
  fs::path part = part_of(folder);
  for (const auto& entry : fs::directory_iterator(folder)) {
    fs::path page_template = entry.path();
    page_template += ".in";
    if (entry.path().string().ends_with(".md.in") || fs::exists(page_template)) continue;
    fs::copy(entry.path(), part / entry.path().filename(), fs::copy_options::recursive);
  }
  return part;
}

void replace_folder(const fs::path& folder, const fs::path& made) {
  fs::path before = folder;
  before += before_ending;
  // A call that was cut off between the two renames has left the templates there.
  if (fs::exists(before) && !fs::exists(folder)) fs::rename(before, folder);
  fs::remove_all(before);
  if (fs::exists(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (!entry.path().string().ends_with(".md.in")) continue;
      fs::copy_file(entry.path(), made / entry.path().filename());
      const fs::path page = page_of(entry.path());
      if (fs::exists(page)) fs::copy_file(page, made / page.filename());
    }
    fs::rename(folder, before);
  }
  fs::rename(made, folder);
  fs::remove_all(before);
}

}  // namespace ertbench
