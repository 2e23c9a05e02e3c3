// A baseline of `ertbench check`, once as it is and once with the checksum that its content has.
// One that is read is written and read again, and stays what it is.

#include "bench/check/baseline.h"
#include "core/checksum.h"
#include "core/json.h"
#include "tests/fuzz/fuzz_input.h"

namespace ertbench {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

void read_and_write(const std::filesystem::path& file) {
  std::string text;
  if (!fuzzing::accepted(file.string(), [&] { text = to_json_text(read_baseline(file)); })) return;
  write(file, text);
  fuzzing::require(to_json_text(read_baseline(file)) == text, "a baseline is read as another",
                   text);
}

}  // namespace
}  // namespace ertbench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "baseline.json");
  nlohmann::json value;
  if (!fuzzing::accepted(file.string(), [&] { value = read_json_file(file); })) return 0;
  read_and_write(file);
  if (!value.is_object()) return 0;
  value.erase("checksum");
  add_checksum(value);
  write(file, json_text(value));
  read_and_write(file);
  return 0;
}
