// An archive of libtorch's is code that runs when it is loaded. What this program keeps are tensors
// (models/networks/tensor_file.h), and nothing in models/ reads or writes such an archive but the
// solver whose file is code by its name, as a plugin is (SECURITY.md).

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace {

namespace fs = std::filesystem;

TEST(Archives, OfTorchAreNeitherReadNorWritten) {
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(ERTBENCH_SOURCE_DIR "/models")) {
    const fs::path extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp") continue;
    if (entry.path().stem() == "torch_script_solver") continue;
    ++files;
    std::ifstream in(entry.path());
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      for (const char* name :
           {"torch::serialize", "torch/serialize", "torch/script.h", "InputArchive",
            "OutputArchive", "torch::load", "torch::save", "torch::pickle", "jit::load",
            "jit::import", "jit::unpickle", "jit::pickle"}) {
        EXPECT_EQ(line.find(name), std::string::npos)
            << entry.path() << ":" << number << ": " << name
            << ": keep tensors with models/networks/tensor_file.h";
      }
    }
  }
  EXPECT_GT(files, 40);
}

}  // namespace
