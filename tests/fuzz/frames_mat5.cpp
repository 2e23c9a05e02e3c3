// A MATLAB file of version 5 to 7: the bytes behind its 128 of text. libmatio, which is not ours,
// crashes on some; the program survives that, as it reads files in a child process first.

#include "frames/frame_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  std::string text = "MATLAB 5.0 MAT-file";
  text.resize(124, ' ');
  text += std::string("\x00\x01IM", 4);
  text.append(reinterpret_cast<const char*>(bytes), size);
  const std::filesystem::path file = fuzzing::file_of(
      reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), "frames.mat");
  fuzzing::accepted(file.string(), [&] {
    const auto frames = open_matlab_frames(file, {});
    const RowMajorMatrix rows = frames->read(0, frames->frames());
    fuzzing::require(rows.size() > 0 && rows.allFinite(), "frames without finite numbers");
  });
  return 0;
}
