// A baseline of `ertbench check`. One that is read is written and read again, and stays what it is.

#include "bench/check/baseline.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "baseline.json");
  std::string text;
  if (!fuzzing::accepted(file.string(), [&] { text = to_json_text(read_baseline(file)); })) {
    return 0;
  }
  std::ofstream(file, std::ios::binary) << text;
  fuzzing::require(to_json_text(read_baseline(file)) == text, "a baseline is read as another",
                   text);
  return 0;
}
