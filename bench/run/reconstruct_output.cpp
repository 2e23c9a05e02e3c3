#include "bench/run/reconstruct_output.h"

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json_reader.h"
#include "core/output_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

bool holds_images(const fs::path& file) {
  try {
    return Hdf5File::open(file).has("/conductivity_change");
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

void require_image_output(const fs::path& output, const std::vector<fs::path>& inputs) {
  require_output(output, inputs, {"file of images (/conductivity_change)", holds_images});
}

std::vector<fs::path> reconstruction_inputs(const fs::path& spec_file, const fs::path& frames) {
  std::vector<fs::path> inputs = {spec_file, frames};
  const nlohmann::json spec = read_json_file(spec_file);
  if (spec.is_object() && spec.contains("checkpoint")) {
    const fs::path checkpoint = JsonObject(spec, spec_file.string(), "").text("checkpoint");
    inputs.push_back(spec_file.parent_path() / checkpoint);
  }
  return inputs;
}

}  // namespace ertbench
