// A MATLAB file of frames: the bytes behind the 512 that MATLAB puts before an HDF5 file.

#include "frames/reconstruct.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  std::string text = "MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .";
  text.resize(512, ' ');
  text.append(reinterpret_cast<const char*>(bytes), size);
  const std::filesystem::path file = fuzzing::file_of(
      reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), "frames.mat");
  fuzzing::accepted(file.string(), [&] { read_frames(file); });
  return 0;
}
