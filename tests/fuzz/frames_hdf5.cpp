// A file of frames, read as `ertbench reconstruct` reads it and as a dataset of the cache. The HDF5
// library, which is not ours, crashes on many of them; the program survives that, as it reads them
// in a child process first.

#include "forward/data/dataset_file.h"
#include "frames/reconstruct.h"
#include "tests/fuzz/fuzz_input.h"

namespace ertbench {
namespace {

void read_dataset(const std::filesystem::path& file) {
  const DatasetFile set(file);
  static_cast<void>(set.why_changed());
  static_cast<void>(set.scenes(0, set.size()));
  static_cast<void>(set.conductivity(0, set.size()));
  static_cast<void>(set.spec());
}

}  // namespace
}  // namespace ertbench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "frames.h5");
  fuzzing::accepted(file.string(), [&] { read_frames(file); });
  fuzzing::accepted(file.string(), [&] { read_dataset(file); });
  return 0;
}
