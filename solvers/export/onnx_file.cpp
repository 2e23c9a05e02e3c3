#include "solvers/export/onnx_file.h"

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/errors.h"
#include "solvers/export/runtime_file.h"

namespace ertbench {
namespace {

static_assert(std::endian::native == std::endian::little, "tensors are written as memory has them");

using Kind = Layer::Kind;
using Sizes = std::vector<std::int64_t>;

/// A message of protobuf: fields by their number in onnx.proto.
class Message {
 public:
  Message& number(int field, std::uint64_t value) {
    varint(static_cast<std::uint64_t>(field) << 3);
    varint(value);
    return *this;
  }
  Message& bytes(int field, const std::string& value) {
    varint(static_cast<std::uint64_t>(field) << 3 | 2);
    varint(value.size());
    out_ += value;
    return *this;
  }
  Message& message(int field, const Message& value) { return bytes(field, value.out_); }
  const std::string& text() const { return out_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 128; value >>= 7) out_ += static_cast<char>(value | 128);
    out_ += static_cast<char>(value);
  }
  std::string out_;
};

/// Numbers of onnx.proto's enumerations.
constexpr int float_type = 1;
constexpr int int64_type = 7;
constexpr int one_integer = 2;
constexpr int integers = 7;

Message attribute(const char* name, std::int64_t value) {
  return Message()
      .bytes(1, name)
      .number(3, static_cast<std::uint64_t>(value))
      .number(20, one_integer);
}

Message attribute(const char* name, const Sizes& values) {
  Message out;
  out.bytes(1, name);
  for (const std::int64_t value : values) out.number(8, static_cast<std::uint64_t>(value));
  return out.number(20, integers);
}

/// ValueInfoProto of an input or output; a size of 0 is the number of frames.
Message value_info(const char* name, const Sizes& sizes) {
  Message shape;
  for (const std::int64_t size : sizes) {
    Message one;
    shape.message(
        1, size > 0 ? one.number(1, static_cast<std::uint64_t>(size)) : one.bytes(2, "frames"));
  }
  const Message tensor = Message().number(1, float_type).message(2, shape);
  return Message().bytes(1, name).message(2, Message().message(1, tensor));
}

/// The graph of a list of layers: each value is the name of a tensor [frames, numbers], or [frames,
/// channels, rows, columns].
class Graph {
 public:
  Graph(const LayerList& list, const runtime::LayerFile& sensor) : list_(list), sensor_(sensor) {}
  Message written();

 private:
  template <typename Number>
  std::string constant(const Sizes& sizes, const std::vector<Number>& numbers,
                       const std::string& name = "") {
    const std::string called = name.empty() ? "c" + std::to_string(next_++) : name;
    Message tensor;
    for (const std::int64_t size : sizes) tensor.number(1, static_cast<std::uint64_t>(size));
    tensor.number(2, std::is_same_v<Number, float> ? float_type : int64_type).bytes(8, called);
    tensor.bytes(9,
                 {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)});
    constants_.push_back(std::move(tensor));
    return called;
  }
  std::string indices(const Sizes& numbers) { return constant({std::ssize(numbers)}, numbers); }
  /// Adds an operation and returns the name of its output.
  std::string node(const char* operation, const std::vector<std::string>& inputs,
                   const std::vector<Message>& attributes = {}, const std::string& name = "") {
    const std::string made = name.empty() ? "v" + std::to_string(next_++) : name;
    Message out;
    for (const std::string& input : inputs) out.bytes(1, input);
    out.bytes(2, made).bytes(3, made + "_" + operation).bytes(4, operation);
    for (const Message& one : attributes) out.message(5, one);
    nodes_.push_back(std::move(out));
    return made;
  }
  std::string taken(const std::string& from, const Sizes& which) {
    return node("Gather", {from, indices(which)}, {attribute("axis", 1)});
  }
  std::string input();
  std::string made(const Layer& layer);
  std::string dense(const Layer& layer, const std::string& from);
  std::string convolution(const Layer& layer, std::string from);
  std::string attention(const Layer& layer, const std::string& from);
  std::string shuffle(const Layer& layer, std::string from);
  std::string mixture(const Layer& layer, const std::string& from);
  std::string activated(const Layer& layer, const std::string& sum);

  const LayerList& list_;
  const runtime::LayerFile& sensor_;
  std::map<int, std::string> values_;
  std::vector<Message> nodes_;
  std::vector<Message> constants_;
  int next_ = 0;
};

std::string Graph::input() {
  const std::string reference =
      constant({sensor_.channels}, sensor_.reference, "reference_voltages");
  const std::string change = node("Sub", {"voltages", reference});
  if (list_.scale.empty()) return change;
  const std::string centred = node("Sub", {change, constant({sensor_.channels}, list_.shift)});
  return node("Mul", {centred, constant({sensor_.channels}, list_.scale)});
}

std::string Graph::activated(const Layer& layer, const std::string& sum) {
  const std::string all = layer.added < 0 ? sum : node("Add", {sum, values_.at(layer.added)});
  if (layer.relu) return node("Relu", {all});
  if (layer.slopes.empty()) return all;
  const bool maps = layer.kind != Kind::dense;
  return node("PRelu", {all, constant(maps ? Sizes{layer.channels, 1, 1} : Sizes{layer.width},
                                      layer.slopes)});
}

std::string Graph::dense(const Layer& layer, const std::string& from) {
  const auto outputs = std::ssize(layer.bias);
  const std::string weights =
      constant({outputs, std::ssize(layer.weights) / outputs}, layer.weights);
  return activated(layer, node("Gemm", {from, weights, constant({outputs}, layer.bias)},
                               {attribute("transB", 1)}));
}

std::string Graph::convolution(const Layer& layer, std::string from) {
  if (layer.inputs.size() > 1) {
    std::vector<std::string> joined;
    for (const int one : layer.inputs) joined.push_back(values_.at(one));
    from = node("Concat", joined, {attribute("axis", 1)});
  }
  const bool transposed = layer.kind == Kind::transposed_convolution;
  const auto taps = static_cast<std::size_t>(layer.kernel * layer.kernel);
  const std::size_t outputs = layer.bias.size();
  const std::size_t inputs = layer.weights.size() / outputs / taps;
  std::vector<float> weights = layer.weights;  // [outputs][inputs][taps]
  for (std::size_t i = 0; transposed && i < weights.size(); ++i) {
    const std::size_t output = i / taps / inputs;
    weights[(i / taps % inputs * outputs + output) * taps + i % taps] = layer.weights[i];
  }
  const auto first = static_cast<std::int64_t>(transposed ? inputs : outputs);
  const auto second = static_cast<std::int64_t>(transposed ? outputs : inputs);
  const std::string sum = node(
      transposed ? "ConvTranspose" : "Conv",
      {from, constant({first, second, layer.kernel, layer.kernel}, weights),
       constant({std::ssize(layer.bias)}, layer.bias)},
      {attribute("strides", Sizes(2, layer.stride)), attribute("pads", Sizes(4, layer.padding))});
  return activated(layer, sum);
}

std::string Graph::attention(const Layer& layer, const std::string& from) {
  const std::vector<Message> channels = {attribute("axes", Sizes{1})};
  const std::string summary =
      node("Concat", {node("ReduceMean", {from}, channels), node("ReduceMax", {from}, channels)},
           {attribute("axis", 1)});
  const std::string sums =
      node("Conv", {summary, constant({1, 2, layer.kernel, layer.kernel}, layer.weights)},
           {attribute("pads", Sizes(4, layer.kernel / 2))});
  return node("Mul", {from, node("Sigmoid", {sums})});
}

std::string Graph::shuffle(const Layer& layer, std::string from) {
  if (layer.added >= 0) {
    from = node("Add", {from, taken(values_.at(layer.added), {0, 1, 2, 3})});
  }
  return node("DepthToSpace", {from}, {attribute("blocksize", 2)});
}

std::string Graph::mixture(const Layer& layer, const std::string& from) {
  const auto components = std::ssize(layer.bias) / (layer.width + 1);
  std::vector<float> logarithms;
  std::vector<float> constants;
  for (auto one = layer.bias.begin(); one != layer.bias.end(); one += layer.width) {
    logarithms.push_back(*one++);
    constants.insert(constants.end(), one, one + layer.width);
  }
  const std::string parts = node("Reshape", {from, indices({0, components, -1})});
  const std::string squares =
      node("ReduceSumSquare", {parts}, {attribute("axes", Sizes{2}), attribute("keepdims", 0)});
  const std::string score = node("Sub", {constant({components}, logarithms),
                                         node("Div", {squares, constant({1}, std::vector{2.0F})})});
  const Message row = attribute("axes", Sizes{1});
  const std::string share = node("Exp", {node("Sub", {score, node("ReduceMax", {score}, {row})})});
  const std::string least = constant({1}, std::vector{least_mixture_share});
  const std::string kept =
      node("Where", {node("Less", {share, least}), constant({1}, std::vector{0.0F}), share});
  const std::string weights = node("Div", {kept, node("ReduceL1", {kept}, {row})});
  const std::int64_t outputs = components * layer.width;
  const std::string estimates =
      node("Gemm",
           {values_.at(layer.inputs[1]),
            constant({outputs, std::ssize(layer.weights) / outputs}, layer.weights),
            constant({outputs}, constants)},
           {attribute("transB", 1)});
  const std::string mean =
      node("MatMul", {node("Reshape", {weights, indices({0, 1, components})}),
                      node("Reshape", {estimates, indices({0, components, layer.width})})});
  return node("Reshape", {mean, indices({0, layer.width})});
}

std::string Graph::made(const Layer& layer) {
  const std::string from = layer.inputs.empty() ? "" : values_.at(layer.inputs[0]);
  switch (layer.kind) {
    case Kind::input:
      return input();
    case Kind::dense:
      return dense(layer, from);
    case Kind::gather: {
      // One zero behind the numbers, which -1 stands for: the last one.
      const std::string padded = node("Pad", {from, indices({0, 0, 0, 1})});
      return taken(padded, {layer.indices.begin(), layer.indices.end()});
    }
    case Kind::means_of_pairs: {
      Sizes of_pair[2];
      for (std::size_t i = 0; i < layer.indices.size(); ++i) {
        of_pair[i % 2].push_back(layer.indices[i]);
      }
      const std::string sum = node("Add", {taken(from, of_pair[0]), taken(from, of_pair[1])});
      return node("Mul", {sum, constant({1}, std::vector{0.5F})});
    }
    case Kind::maps:
      return node("Reshape", {from, indices({0, layer.channels, layer.height, layer.width})});
    case Kind::convolution:
    case Kind::transposed_convolution:
      return convolution(layer, from);
    case Kind::pool:
      return node("MaxPool", {from},
                  {attribute("kernel_shape", {2, 2}), attribute("strides", Sizes{2, 2})});
    case Kind::attention:
      return attention(layer, from);
    case Kind::shuffle:
      return shuffle(layer, from);
    case Kind::sigmoid:
      return node("Sigmoid", {from});
    case Kind::mixture:
      return mixture(layer, from);
  }
  throw InputError("has layers that ONNX does not have");
}

Message Graph::written() {
  for (const Layer& layer : list_.layers) values_[layer.value] = made(layer);
  const Sizes image = {0, sensor_.rows, sensor_.columns};
  const std::string last = node("Reshape", {values_.at(list_.layers.back().value), indices(image)});
  std::vector<float> units(static_cast<std::size_t>(sensor_.rows * sensor_.columns),
                           static_cast<float>(list_.unit));
  for (const int pixel : sensor_.no_sheet) units[static_cast<std::size_t>(pixel)] = 0;
  const char* const output = "conductivity_change";
  node("Mul", {last, constant({sensor_.rows, sensor_.columns}, units)}, {}, output);
  Message graph;
  for (const Message& one : nodes_) graph.message(1, one);
  graph.bytes(2, sensor_.name);
  for (const Message& one : constants_) graph.message(5, one);
  return graph.message(11, value_info("voltages", {0, sensor_.channels}))
      .message(11, value_info("reference_voltages", {sensor_.channels}))
      .message(12, value_info(output, image));
}

}  // namespace

std::map<std::string, std::string> onnx_file(const LayerList& list, const CExport& how) {
  const runtime::LayerFile sensor = sensor_and_rule(how);
  const Message graph = Graph(list, sensor).written();
  const Message model = Message()
                            .number(1, 7)  // of the format, with opset 13
                            .bytes(2, "ertbench export")
                            .message(7, graph)
                            .message(8, Message().bytes(1, "").number(2, 13));
  return {{sensor.name + ".onnx", model.text()}};
}

}  // namespace ertbench
