// ertbench: reconstruction methods of tomographic tactile skins, compared.
//
//   ertbench run experiments/quick.json
//   ertbench generate experiments/table_c1.json --dataset test --out test.h5
//   ertbench reconstruct --solver solver.json --input frames.h5 --output images.h5
//   ertbench check experiments/quick.json
//   ertbench list
//   ertbench timing 'reconstruct/tsvd'

#include "bench/cli/command.h"

// For builds with the leak sanitizer, which asks the program itself by these names: libhdf5 loses a
// few hundred bytes when it refuses some damaged files.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }

int main(int argc, char** argv) { return ertbench::run_command_line(argc, argv); }
