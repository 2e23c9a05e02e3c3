#include "runtime/layer_file.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace ertbench::runtime {
namespace {

static_assert(std::endian::native == std::endian::little, "files are written as memory has them");

constexpr char magic[] = "ERTRUN2\n";
constexpr std::size_t magic_size = sizeof magic - 1;

std::uint64_t checksum_of(const char* bytes, std::size_t size) {
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (std::size_t i = 0; i < size; ++i) {
    sum = (sum ^ static_cast<unsigned char>(bytes[i])) * 0x100000001b3U;
  }
  return sum;
}

template <typename Archive>
void visit(Archive& archive, Layer& layer);

/// Appends what it visits to a text.
struct Writer {
  std::string out;

  template <typename Number>
  void number(const Number& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <typename List>
  void list(const List& values) {
    number(static_cast<std::uint64_t>(values.size()));
    if constexpr (std::is_same_v<List, std::vector<Layer>>) {
      for (const Layer& layer : values) visit(*this, const_cast<Layer&>(layer));
    } else {
      out.append(reinterpret_cast<const char*>(values.data()),
                 values.size() * sizeof(typename List::value_type));
    }
  }
};

/// Fills what it visits from a text.
struct Reader {
  const char* at;
  std::size_t left;

  void take(void* to, std::size_t size) {
    if (size > left) throw std::runtime_error("it ends too early");
    if (size > 0) std::memcpy(to, at, size);
    at += size;
    left -= size;
  }
  template <typename Number>
  void number(Number& value) {
    take(&value, sizeof value);
  }
  template <typename List>
  void list(List& values) {
    std::uint64_t size = 0;
    number(size);
    if (size > left) throw std::runtime_error("it ends too early");  // each takes a byte or more
    values.resize(size);
    if constexpr (std::is_same_v<List, std::vector<Layer>>) {
      for (Layer& layer : values) visit(*this, layer);
    } else {
      if (size > left / sizeof(typename List::value_type)) {
        throw std::runtime_error("it ends too early");
      }
      take(values.data(), size * sizeof(typename List::value_type));
    }
  }
};

template <typename Archive>
void visit(Archive& archive, Layer& layer) {
  for (int* one :
       {reinterpret_cast<int*>(&layer.kind), &layer.value, &layer.channels, &layer.height,
        &layer.width, &layer.added, &layer.kernel, &layer.stride, &layer.padding}) {
    archive.number(*one);
  }
  std::uint8_t relu = layer.relu ? 1 : 0;
  archive.number(relu);
  layer.relu = relu != 0;
  archive.list(layer.inputs);
  archive.list(layer.weights);
  archive.list(layer.bias);
  archive.list(layer.slopes);
  archive.list(layer.indices);
}

template <typename Archive>
void visit(Archive& archive, FrameFront& front) {
  archive.number(front.electrodes);
  archive.number(front.told);
  archive.number(front.neighbours);
  archive.number(front.of_change);
  archive.list(front.pairs);
  archive.list(front.users);
  archive.list(front.least_bad);
  archive.list(front.reference);
  for (double* one : {&front.reference_square, &front.noise, &front.noise_slope, &front.limit,
                      &front.least_size, &front.residual, &front.residual_slope}) {
    archive.number(*one);
  }
  archive.list(front.directions);
}

template <typename Archive>
void visit(Archive& archive, LayerFile& file) {
  archive.list(file.name);
  for (int* one : {&file.channels, &file.rows, &file.columns}) archive.number(*one);
  archive.list(file.reference);
  archive.list(file.no_sheet);
  for (float* one : {&file.threshold, &file.floor, &file.saddle, &file.x_mm, &file.y_mm,
                     &file.width_mm, &file.height_mm}) {
    archive.number(*one);
  }
  archive.number(file.list.unit);
  archive.list(file.list.shift);
  archive.list(file.list.scale);
  archive.list(file.list.layers);
  visit(archive, file.front);
}

}  // namespace

std::string bytes_of(const LayerFile& file) {
  Writer body;
  LayerFile copy = file;
  visit(body, copy);
  Writer all;
  all.out.assign(magic, magic_size);
  all.number(static_cast<std::uint64_t>(body.out.size()));
  all.number(checksum_of(body.out.data(), body.out.size()));
  return all.out + body.out;
}

LayerFile layer_file_from(const std::string& bytes) {
  if (bytes.compare(0, magic_size, magic) != 0) {
    throw std::runtime_error(
        "is no solver that `ertbench export --to runtime` of this version wrote");
  }
  Reader reader{bytes.data() + magic_size, bytes.size() - magic_size};
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;
  LayerFile out;
  try {
    reader.number(size);
    reader.number(checksum);
    if (reader.left != size || checksum_of(reader.at, reader.left) != checksum) {
      throw std::runtime_error("its checksum is another one");
    }
    visit(reader, out);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("is damaged (" + std::string(error.what()) + "); export it again");
  }
  return out;
}

}  // namespace ertbench::runtime
