#include "models/training/training_settings.h"

#include "core/fields.h"

namespace ertbench {

Faults TrainingFaults::draw(RandomStream& random) const {
  Faults faults;
  if (random.uniform() < share) {
    faults.dead_electrodes = random.integer(dead_electrodes.first, dead_electrodes.second);
    faults.dead_reading = dead_reading;
    faults.gain_error = random.uniform(gain_error.first, gain_error.second);
    faults.offset = random.uniform(offset.first, offset.second);
  }
  if (!of_sheet()) return faults;
  const auto drawn = [&](const std::pair<double, double>& sizes) {
    const double size = random.uniform(sizes.first, sizes.second);
    return random.uniform() < share ? size : 0;
  };
  faults.background_change = drawn(level);
  faults.background_gradient = drawn(gradient);
  faults.electrode_displacement = drawn(displacement);
  return faults;
}

void visit(Fields& fields, TrainingFaults& faults) {
  if (fields.writing() && !faults) return;
  bool given = false;
  fields.object("training_faults", [&](Fields& sizes) {
    given = true;
    // The smallest sensor has five electrodes; ChannelMask keeps as many.
    sizes.interval("dead_electrodes", faults.dead_electrodes, 0, 59);
    sizes.choice("dead_reading", faults.dead_reading,
                 {{"zero", DeadReading::zero}, {"floating", DeadReading::floating}});
    sizes.interval("gain_error", faults.gain_error, {0, 10});
    sizes.interval("offset", faults.offset, {0, 10});
    if (!fields.writing() || faults.of_sheet()) {
      sizes.interval("level", faults.level, {-0.9, 0.9});
      sizes.interval("gradient", faults.gradient, {0, 0.9});
      sizes.interval("displacement", faults.displacement, {0, 0.1});
    }
    if (!fields.writing() || faults.snr_db) sizes.interval("snr_db", faults.snr_db, {-20, 200});
  });
  if (!given && fields.has("fault_share")) {
    fields.fail("fault_share", "stands without \"training_faults\"; add them or remove it");
  }
  fields.number("fault_share", faults.share, {0, 1, true});
  if (fields.reading() && given && !faults) {
    fields.fail("training_faults", "has no fault above zero; give one or remove it");
  }
}

void visit(Fields& fields, TrainingSettings& settings) {
  fields.integer("seed", settings.seed, 0, 2147483647);
  fields.integer("epochs", settings.epochs, 1, 100000);
  fields.integer("batch", settings.batch, 2, 65536);
  fields.number("learning_rate", settings.learning_rate, {0, 10, true});
  fields.choice("schedule", settings.one_cycle, {{"one-cycle", true}, {"constant", false}});
  fields.number("slow_rate", settings.slow_rate, {0, 1});
  fields.number("freeze_statistics", settings.freeze_statistics, {0, 1});
  fields.choice("precision", settings.bfloat16, {{"float32", false}, {"bfloat16", true}});
  // Not written: as the number of threads, it changes a network by rounding alone.
  if (!fields.writing()) fields.name("device", settings.device, {"auto", "cpu", "cuda"});
  fields.boolean("symmetries", settings.symmetries);
  fields.boolean("new_scenes", settings.new_scenes);
  fields.integer("patience", settings.patience, 1, 100000);
  visit(fields, settings.faults);
}

}  // namespace ertbench
