#include "forward/data/fresh_scenes.h"

#include <variant>
#include <vector>

#include "core/errors.h"
#include "core/random.h"
#include "forward/data/dataset_file.h"
#include "forward/data/faults.h"

namespace ertbench {

DatasetSpec continued_spec(const DatasetFile& file) {
  DatasetSpec spec = file.spec();
  if (std::holds_alternative<std::vector<Scene>>(spec.scenes) || spec.sequences() ||
      spec.measured()) {
    throw InputError(file.path().string() +
                     ": its scenes are listed, measured or move, so that no others can be drawn; "
                     "give the training set a distribution, or do without new scenes");
  }
  return spec;
}

FreshScenes::FreshScenes(const DatasetFile& file, std::uint64_t seed, int threads)
    : spec_(continued_spec(file)),
      reference_(file.reference_voltages()),
      model_(spec_.sensor, spec_.model),
      seed_(seed),
      number_(file.size()),
      threads_(threads) {}

FreshScenes::Block FreshScenes::next(std::uint64_t count) {
  const DatasetBlock drawn = generate_block(spec_, model_, number_, count, threads_);
  const std::vector<Symmetry> turns = symmetries(spec_.sensor);
  Block out{Frames(drawn.clean_voltages.rows(), drawn.clean_voltages.cols()),
            Images(drawn.conductivity.rows(), drawn.conductivity.cols())};
  Eigen::VectorXd frame;
  for (Eigen::Index i = 0; i < out.changes.rows(); ++i) {
    RandomStream random(seed_, key_of("fresh"), number_++, Purpose::training);
    const auto most = static_cast<int>(turns.size()) - 1;
    const Symmetry& turn = turns[static_cast<std::size_t>(random.integer(0, most))];
    frame = drawn.clean_voltages.row(i)(turn.channels);
    add_noise(spec_.noise, reference_, random, frame);
    out.changes.row(i) = frame - reference_;
    out.image_changes.row(i) =
        drawn.conductivity.row(i)(turn.pixels).array() - spec_.sensor.background;
  }
  return out;
}

}  // namespace ertbench
