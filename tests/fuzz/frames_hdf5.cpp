// A file of frames, read as `ertbench reconstruct` reads it. The HDF5 library, which is not ours,
// crashes on many of them; the program survives that, as it reads them in a child process first.

#include "bench/run/reconstruct.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "frames.h5");
  fuzzing::accepted(file.string(), [&] { read_frames(file); });
  return 0;
}
