#pragma once

#include <filesystem>
#include <utility>

namespace ertbench {

/// The name of this process under which a file grows beside its place.
std::filesystem::path aside_of(const std::filesystem::path& file);

/// Puts `aside` in the place of `file`. Throws InputError where that fails; `aside` is gone then.
void put_in_place(const std::filesystem::path& aside, const std::filesystem::path& file);

/// Makes a file by `write(aside)`, which writes another beside it, and puts that in its place: what
/// stands under `file` is whole whenever the process ends. A killed process leaves `aside`; name
/// one where a lock lets no other process write, so that the next one writes over it. What `write`
/// throws is passed on, and nothing is left behind. For bytes in memory that must last there is
/// write_file_atomically.
template <typename Write>
void replace_file(const std::filesystem::path& file, Write&& write,
                  const std::filesystem::path& aside) {
  try {
    write(aside);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);
    throw;
  }
  put_in_place(aside, file);
}
template <typename Write>
void replace_file(const std::filesystem::path& file, Write&& write) {
  replace_file(file, std::forward<Write>(write), aside_of(file));
}

}  // namespace ertbench
