#include "bench/cli/frame_options.h"

#include "bench/frames/channel_order.h"

namespace ertbench {

void add_frame_options(CLI::App& command, const std::shared_ptr<OwnFramesOptions>& options) {
  // CLI11 keeps references to what it fills; the owner lives in the command's action.
  const auto path = [&command, options](const char* name, std::filesystem::path& to,
                                        const char* help) {
    command.add_option_function<std::string>(
        name, [options, &to](const std::string& text) { to = text; }, help);
  };
  path("--sensor", options->sensor,
       "JSON of the sensor, or an experiment with one (default: what the frames' file\n"
       "says, else EIDORS's d2s)");
  std::string orders;
  for (const NamedOrder& order : named_orders()) {
    orders += std::string("\n  ") + order.name + ": " + order.description;
  }
  command.add_option(
      "--channels", options->channels,
      "Order of the columns (default: the sensor's own, or full, by their number;\nof .eit files "
      "what they say):" +
          orders +
          "\n  or a file, or a dataset of the input (/NAME), with a line \"drive measurement\"\n"
          "  or \"drive measurement sign\" for each column, counted from 0");
  command.add_option("--unit", options->unit,
                     "Of the numbers in the file: V, mV or uV (default: V)");
  command.add_option("--dataset", options->file.dataset,
                     "Dataset or variable with the frames (default: /voltages);\n"
                     "of .eit files with several frequencies the number of one, from 1");
  command.add_flag("--transposed", options->file.transposed, "Frames are columns of the file");
}

}  // namespace ertbench
