// Frames as text: a table of numbers, and an instrument's .eit file. What is accepted is finite and
// has one shape.

#include "frames/frame_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  fuzzing::accepted("frames.csv", [&] {
    const RowMajorMatrix rows = numbers_of_text(text, "frames.csv");
    fuzzing::require(rows.size() > 0 && rows.allFinite(), "a table without finite numbers");
  });
  fuzzing::accepted("frame.eit", [&] {
    const EitFile file = parse_eit(text, "frame.eit");
    const auto rows = static_cast<Eigen::Index>(file.injections.size());
    const auto columns = static_cast<Eigen::Index>(file.electrodes.size()) * file.frequencies;
    fuzzing::require(file.in_phase.rows() == rows && file.in_phase.cols() == columns &&
                         file.in_phase.allFinite() && file.quadrature.allFinite(),
                     "potentials of another shape than the header's");
  });
  return 0;
}
