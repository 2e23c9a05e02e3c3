#include "solvers/export/c_source.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/lists.h"
#include "solvers/export/c_constants.h"
#include "solvers/export/quantised.h"
#include "solvers/export/runtime_file.h"

namespace ertbench {

const std::string& c_solver_header();
const std::string& c_layers();
const std::string& c_float_kernels();
const std::string& c_int8_kernels();
const std::string& c_steps();
const std::string& c_contacts();
const std::string& c_front();
const std::string& c_example();

namespace {

using StepKind = ExportStep::Kind;
constexpr std::array<const char*, 3> precisions = {"float32", "float16", "int8"};

/// `$KEY$` in the text replaced by the value of each key.
std::string filled(std::string text, const std::map<std::string, std::string>& values) {
  for (const auto& [key, value] : values) {
    const std::string mark = "$" + key + "$";
    for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += value.size()) {
      text.replace(at, mark.size(), value);
    }
  }
  return text;
}

/// The part of steps.c.in below the line "//// NAME".
std::string part(const std::string& name) {
  const std::string mark = "//// " + name + "\n";
  const std::size_t at = c_steps().find(mark);
  if (at == std::string::npos) throw std::logic_error("steps.c.in has no part " + name);
  const std::size_t first = at + mark.size();
  return c_steps().substr(first, c_steps().find("//// ", first) - first);
}

/// Outputs that are summed together, as many as the number of outputs allows.
int group_of(const ExportStep& step) {
  return step.outputs % 8 == 0 ? 8 : step.outputs % 4 == 0 ? 4 : 1;
}

/// Inputs that are added in a row, which divide the channels.
int step_of(const ExportProgram::Value& from) {
  int step = 8;
  while (from.channels % step != 0) step /= 2;
  return step;
}

int components_of(const ExportStep& mixture) {
  return static_cast<int>(mixture.bias.size()) / (mixture.outputs + 1);
}

/// Writes one program.
class Writer {
 public:
  Writer(const ExportProgram& program, const CExport& how)
      : program_(program), how_(how), numbers_(sensor_and_rule(how)) {
    if (is_int8()) quantised_ = quantise(program, how.ranges);
  }
  std::map<std::string, std::string> files();

 private:
  bool is_int8() const { return how_.precision == ExportPrecision::int8; }
  bool is_half() const { return how_.precision == ExportPrecision::float16; }
  std::string place(int value) const { return std::to_string(program_.value(value).place); }
  std::string weights(std::size_t index);
  void add_layer(std::size_t index);
  void add_call(std::size_t index);
  void add_steps();
  void add_input();
  std::size_t front_directions() const;
  void add_front();
  bool needs_exp() const { return parts_.count("sigmoid") + parts_.count("mixture") > 0; }
  /// Takes a function that has another source for integers.
  void use(const std::string& name) { parts_.insert(is_int8() ? name + " int8" : name); }
  std::string contact_numbers() const;
  std::map<std::string, std::string> words();
  std::string heading(const std::string& what) const {
    return "/* " + name_ + ": " + what + ", by ertbench export */\n";
  }

  const ExportProgram& program_;
  const CExport& how_;
  runtime::LayerFile numbers_;  ///< without layers
  std::string name_;
  QuantisedProgram quantised_;
  Constants constants_;
  std::string layers_;  ///< definitions in ert_layers
  std::map<std::string, std::string> sums_;
  std::string calls_;
  std::set<std::string> parts_;
  std::string front_;  ///< what is done with a frame, and its numbers
};

std::string Writer::weights(std::size_t index) {
  const ExportStep& step = program_.steps()[index];
  const std::string name = "ert_weights_" + std::to_string(index);
  const int group = group_of(step);
  if (is_int8()) {
    const std::vector<std::int8_t> all =
        grouped(quantised_.steps[index].weights, step.outputs, group,
                std::min(2, step_of(program_.value(step.inputs[0]))));
    return constants_.add("ErtWeight", name, std::vector<int>(all.begin(), all.end()), 1);
  }
  const int components = step.kind == StepKind::mixture ? components_of(step) : 1;
  const std::vector<float> all = grouped(step.weights, components * step.outputs, group, 1);
  if (!is_half()) return constants_.add("ErtWeight", name, all, 4);
  std::vector<int> halves;
  for (const float one : all) halves.push_back(Eigen::half(one).x);
  return constants_.add("ErtWeight", name, halves, 2);
}

void Writer::add_layer(std::size_t index) {
  const ExportStep& step = program_.steps()[index];
  const ExportProgram::Value& from = program_.value(step.inputs[0]);
  const std::string number = std::to_string(index);
  const std::string group = std::to_string(group_of(step));
  const std::string each = std::to_string(step_of(from));
  const std::string sum = group + "_" + each;
  sums_[group] = "\n" + filled(part("finish"), {{"N", group}});
  sums_[sum] = "\n" + filled(part("sum"), {{"N", group}, {"STEP", each}});
  layers_ += fmt::format(
      "  static const ErtLayer layer_{} = {{\n"
      "      .sum = ert_sum_{}, .finish = ert_finish_{},\n"
      "      .from = {}, .rows = {}, .columns = {}, .channels = {},\n"
      "      .to = {}, .out_rows = {}, .out_columns = {}, .outputs = {},\n"
      "      .kernel = {}, .stride = {}, .padding = {}, .group = {},\n"
      "      .spread = {}, .row = {}, .column = {}, .positive = {},\n"
      "      .added = {}, .added_channels = {},\n",
      index, sum, group, from.place, from.rows, from.columns, from.channels, place(step.value),
      program_.sum_rows(step), program_.sum_columns(step), step.outputs, step.kernel, step.stride,
      step.padding, group, step.spread, step.row, step.column, step.relu ? 1 : 0,
      step.added < 0 ? "-1" : place(step.added),
      step.added < 0 ? 0 : program_.value(step.added).channels);
  layers_ += "      .weights = " + weights(index);
  if (is_int8()) {
    const QuantisedProgram::Step& whole = quantised_.steps[index];
    const auto list = [&](const char* name, const std::vector<std::int32_t>& numbers) {
      return constants_.add("int32_t", name + number, numbers, 4);
    };
    layers_ += ", .bias = " + list("ert_bias_", whole.bias);
    layers_ += ", .factors = " + list("ert_factors_", whole.factors);
    if (step.added >= 0) layers_ += ",\n      .added_factors = " + list("ert_added_", whole.added);
  } else {
    layers_ += ", .bias = " + constants_.add("float", "ert_bias_" + number, step.bias, 4);
  }
  layers_ += "};\n";
  if (step.kind != StepKind::mixture) {
    calls_ += fmt::format("  ert_convolve(&layer_{}, numbers);\n", index);
    return;
  }
  parts_.insert("mixture");
  const int components = components_of(step);
  calls_ += fmt::format("  ert_mixture(&layer_{}, {}, {}, {}, &numbers[{}], numbers);\n", index,
                        components, program_.value(step.inputs[1]).channels / components,
                        c_number(least_mixture_share), place(step.inputs[1]));
}

void Writer::add_call(std::size_t index) {
  const ExportStep& step = program_.steps()[index];
  const ExportProgram::Value& from = program_.value(step.inputs[0]);
  const ExportProgram::Value& to = program_.value(step.value);
  const std::string in = "&numbers[" + place(step.inputs[0]) + "]";
  const std::string out = "&numbers[" + place(step.value) + "]";
  const auto call = [&](const char* name, const auto&... words) {
    const std::vector<std::string> all = {fmt::to_string(words)...};
    calls_ += fmt::format("  {}({});\n", name, joined(all));
  };
  switch (step.kind) {
    case StepKind::convolve:
    case StepKind::mixture:
      return add_layer(index);
    case StepKind::sums_of_pairs:
      parts_.insert("sums");
      return call("ert_sum_pairs", constants_.add("uint16_t", "ert_pairs", step.indices, 2), in,
                  out, step.indices.size() / 2);
    case StepKind::gather:
      parts_.insert("gather");
      return call("ert_gather", constants_.add("int16_t", "ert_sources", step.indices, 2), in, out,
                  step.indices.size());
    case StepKind::pool:
      parts_.insert("pool");
      return call("ert_pool", in, from.columns, from.channels, out, to.rows, to.columns);
    case StepKind::prelu: {
      use("prelu");
      const std::string name = "ert_slopes_" + std::to_string(index);
      return call("ert_prelu",
                  is_int8() ? constants_.add("int32_t", name, quantised_.steps[index].factors, 4)
                            : constants_.add("float", name, step.weights, 4),
                  in, from.size(), from.channels, out);
    }
    case StepKind::join: {
      use("join");
      int first = 0;
      for (std::size_t i = 0; i < step.inputs.size(); ++i) {
        const int own = program_.value(step.inputs[i]).channels;
        calls_ +=
            fmt::format("  ert_join(&numbers[{}], {}, {}, {}, {}, {}{});\n", place(step.inputs[i]),
                        from.pixels(), own, out, first, to.channels,
                        is_int8() ? fmt::format(", {}", quantised_.steps[index].factors[i]) : "");
        first += own;
      }
      return;
    }
    case StepKind::shuffle:
      parts_.insert("shuffle");
      return call("ert_shuffle", in, from.rows, from.columns, out);
    case StepKind::sigmoid: {
      const bool image = step.value == program_.output();
      if (is_int8() && image) return;  // a table, where the image is written
      use("sigmoid");
      if (!is_int8()) return call("ert_sigmoid", in, from.size());
      const std::vector<int> table = sigmoid_table(quantised_.values[index_of(step.value)].step);
      const std::string name = "ert_sigmoids_" + std::to_string(index);
      return call("ert_sigmoid", constants_.add("uint16_t", name, table, 2), in, from.size());
    }
    case StepKind::summarise:
      use("summarise");
      return call("ert_summarise", in, from.pixels(), from.channels, out);
    case StepKind::weigh:
      use("weigh");
      return call("ert_weigh", in, "&numbers[" + place(step.inputs[1]) + "]", from.pixels(),
                  from.channels, out);
  }
}

void Writer::add_input() {
  if (is_int8() || program_.is_standardised()) {
    std::vector<float> scale = program_.scale();
    const auto step = static_cast<float>(is_int8() ? quantised_.values[0].step : 1);
    for (float& one : scale) one /= step;
    constants_.add("float", "ert_shift", program_.shift(), 4);
    constants_.add("float", "ert_scale", scale, 4);
  }
  constants_.add("float", "ert_reference", numbers_.reference, 4);
}

std::size_t Writer::front_directions() const {
  return how_.front.directions.size() / how_.front.users.size();
}

void Writer::add_front() {
  const FrameFront& front = how_.front;
  if (front.electrodes == 0) return;
  constants_.add("uint16_t", "ert_front_pairs", front.pairs, 2);
  constants_.add("uint64_t", "ert_front_users", front.users, 8);
  constants_.add("uint16_t", "ert_front_least_bad", front.least_bad, 2);
  constants_.add("float", "ert_front_reference",
                 std::vector<float>(front.reference.begin(), front.reference.end()), 4);
  constants_.add("float", "ert_front_directions", front.directions, 4);
  front_ = c_front() + "\nstatic const ErtFrontModel ert_front_model = {\n";
  const auto field = [&](const char* name, const std::string& value) {
    front_ += "    ." + std::string(name) + " = " + value + ",\n";
  };
  field("channels", std::to_string(numbers_.channels));
  field("electrodes", std::to_string(front.electrodes));
  field("pairs", std::to_string(front.users.size()));
  field("directions", std::to_string(front_directions()));
  field("told", std::to_string(front.told));
  field("neighbours", std::to_string(front.neighbours));
  field("of_change", std::to_string(front.of_change));
  for (const auto& [name, value] :
       {std::pair{"noise", front.noise}, std::pair{"noise_slope", front.noise_slope},
        std::pair{"limit", front.limit}, std::pair{"least_size", front.least_size},
        std::pair{"residual", front.residual}, std::pair{"residual_slope", front.residual_slope},
        std::pair{"reference_square", front.reference_square}}) {
    field(name, c_number(value));
  }
  field("pair", "ert_front_pairs");
  field("users", "ert_front_users");
  field("least_bad", "ert_front_least_bad");
  field("reference", "ert_front_reference");
  field("direction", "ert_front_directions");
  front_ += "};\n\n";
}

std::string Writer::contact_numbers() const {
  std::string out;
  const auto define = [&](const char* name, float value, const char* what) {
    out += "#define ERT_" + std::string(name) + " " + c_number(value) + " /* " + what + " */\n";
  };
  define("THRESHOLD", numbers_.threshold, "of the largest change: less is no contact");
  define("FLOOR", numbers_.floor, "S/m: less is no contact");
  define("SADDLE", numbers_.saddle, "of the lower of two summits: less divides them");
  define("X_MM", numbers_.x_mm, "centre of the first pixel");
  define("Y_MM", numbers_.y_mm, "");
  define("WIDTH_MM", numbers_.width_mm, "of a pixel");
  define("HEIGHT_MM", numbers_.height_mm, "");
  return out;
}

std::map<std::string, std::string> Writer::words() {
  std::vector<std::string> library;
  if (is_half() || is_int8()) library.emplace_back("memcpy");
  if (needs_exp()) library.emplace_back("expf");
  std::string front;
  if (!front_.empty()) {
    library.emplace_back("log10");
    const auto products = front_directions() * (front_directions() + 1) / 2;
    front = "#define ERT_TOLD " + std::to_string(how_.front.told) +
            " /* of dead electrodes and noise */" + "\n#define ERT_DIRECTIONS " +
            std::to_string(front_directions()) + "\n#define ERT_PRODUCTS " +
            std::to_string(products) + "\n";
  }
  return {{"NAME", name_},
          {"PRECISION", name_of(how_.precision)},
          {"LIBRARY", library.empty() ? "nothing" : joined(library, " and ")},
          {"FRONT", front},
          {"STATE", front.empty() ? "" : part("state front")},
          {"WORK", front.empty() ? "" : "    double work[ERT_PRODUCTS + ERT_DIRECTIONS];\n"},
          {"CHANNELS", std::to_string(numbers_.channels)},
          {"ROWS", std::to_string(numbers_.rows)},
          {"COLUMNS", std::to_string(numbers_.columns)},
          {"NUMBERS", std::to_string(program_.memory())},
          {"NUMBER", is_int8() ? "int16_t" : "float"},
          {"WEIGHT_BYTES", std::to_string(constants_.bytes())}};
}

std::map<std::string, std::string> Writer::files() {
  // A name is text of the user's: what may stand in a comment.
  for (const char one : how_.name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(one)) != 0;
    if (plain || std::strchr("._ -+=,", one)) name_ += one;
  }
  for (std::size_t i = 0; i < program_.steps().size(); ++i) add_call(i);
  add_input();
  add_front();
  const ExportStep& last = program_.steps().back();
  const bool sigmoid = is_int8() && last.kind == StepKind::sigmoid;
  const double step = is_int8() ? quantised_.values[index_of(program_.output())].step : 1;
  if (sigmoid) constants_.add("uint16_t", "ert_sigmoids", sigmoid_table(step), 2);
  std::string solver =
      heading("the layers, the image and the contacts") + "#include \"solver.h\"\n\n";
  if (needs_exp() || !front_.empty()) solver += "#include <math.h>\n";
  if (is_half()) solver += "#include <string.h>\n";
  if (is_int8()) solver += part("includes int8");
  solver += "#include \"weights.h\"\n\n";
  const double unit = program_.unit() * (sigmoid ? std::ldexp(1.0, -24) : step);
  solver += "#define ERT_UNIT " + c_number(static_cast<float>(unit)) + " /* of the image, S/m */\n";
  if (is_int8()) {
    solver += "#define ERT_MOST_INPUT " + std::to_string(quantised_.values[0].most) +
              "\n#define ERT_BITS " + std::to_string(quantised_.bits) +
              " /* of a layer's numbers, without the sign */\n";
  }
  solver += contact_numbers();
  solver += std::string("\ntypedef ") + (is_int8() ? "int32_t" : "float") + " ErtSum;\n\n";
  const std::string kernels =
      is_int8() ? c_int8_kernels()
                : part(is_half() ? "weight float16" : "weight float32") + c_float_kernels();
  std::string sums;
  for (const auto& [name, text] : sums_) sums += text;
  solver += filled(c_layers(), {{"FIELDS", part(is_int8() ? "fields int8" : "fields float32")},
                                {"KERNELS", kernels},
                                {"SUMS", sums}});
  for (const std::string& name : parts_) solver += "\n" + part(name);
  solver += "\n" + part(sigmoid     ? "image int8 sigmoid"
                        : is_int8() ? "image int8"
                                    : "image float32");
  solver += "\n" + part(is_int8()                    ? "set int8"
                        : program_.is_standardised() ? "set float32 standardised"
                                                     : "set float32");
  solver += "\nstatic void ert_layers(ErtNumber *numbers, float image[ERT_PIXELS])\n{\n" + layers_ +
            calls_ + "  ert_write_image(&numbers[" + place(program_.output()) + "], image);\n";
  for (const int p : numbers_.no_sheet) {
    solver += "  image[" + std::to_string(p) + "] = 0.0F; /* no sheet */\n";
  }
  const std::string which = front_.empty() ? "" : " front";
  const std::string fill =
      front_.empty()
          ? ""
          : "  ert_fill_reference(&ert_front_model, solver->frame, solver->reference);\n";
  solver += "}\n\n" + front_ + part("start" + which) + filled(part("calls"), {{"FILL", fill}}) +
            part("images" + which) + c_contacts() + "\n" + part("contacts");
  return {
      {"solver.h", filled(c_solver_header(), words())},
      {"solver.c", solver},
      {"weights.h", heading("constants of its layers") +
                        "#ifndef ERT_WEIGHTS_H\n#define ERT_WEIGHTS_H\n\n#include <stdint.h>\n\n" +
                        part("weights " + std::string(name_of(how_.precision))) +
                        constants_.declarations() + "\n#endif\n"},
      {"weights.c",
       heading("constants of its layers") + "#include \"weights.h\"\n" + constants_.definitions()},
      {"example.c", c_example()}};
}

}  // namespace

ExportPrecision precision_from_name(const std::string& name) {
  const auto found = std::find(precisions.begin(), precisions.end(), name);
  if (found == precisions.end()) throw std::logic_error("no precision " + name);
  return static_cast<ExportPrecision>(found - precisions.begin());
}

const char* name_of(ExportPrecision precision) {
  return precisions[static_cast<std::size_t>(precision)];
}

std::map<std::string, std::string> c_source(const ExportProgram& program, const CExport& how) {
  return Writer(program, how).files();
}

}  // namespace ertbench
