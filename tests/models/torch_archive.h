#pragma once

#include <torch/script.h>

#include <filesystem>
#include <string>

namespace ertbench::testing {

/// Writes an archive of libtorch's with a program in it: whoever loads it writes `marker`.
inline void write_prepared_archive(const std::filesystem::path& file,
                                   const std::filesystem::path& marker) {
  torch::jit::Module module("Prepared");
  module.define("def __getstate__(self):\n  return 1\n");
  module.define("def __setstate__(self, state: int):\n  torch.save([state], '" + marker.string() +
                "')\n");
  module.save(file.string());
}

}  // namespace ertbench::testing
