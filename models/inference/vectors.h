#pragma once

#include <cstdint>
#include <cstring>

// Arrays of floats in the processor's vector registers. Functions take them by reference, because
// passing them by value differs between instruction sets.
namespace ertbench {

/// Channels of a map in one block, and outputs of a dense layer in one block.
constexpr int lanes = 16;

/// A class, because GCC drops the attribute of an alias whose size is a template parameter.
template <int count>
struct FloatVector {
  typedef float Type __attribute__((vector_size(count * sizeof(float))));  // NOLINT(modernize-*)
};
template <int count>
using Floats = typename FloatVector<count>::Type;

/// Floats in a register, and registers that a kernel uses for sums; the others hold its inputs.
/// Longer vectors than the processor has would be split through memory.
#ifdef __AVX512F__
constexpr int native_lanes = 16;
constexpr int sum_registers = 24;
#elif defined(__AVX__)
constexpr int native_lanes = 8;
constexpr int sum_registers = 12;
#else
constexpr int native_lanes = 4;
constexpr int sum_registers = 12;
#endif
using Native = Floats<native_lanes>;
/// In a block of channels.
constexpr int block_vectors = lanes / native_lanes;

template <typename Vector>
inline void load(Vector& out, const float* from) {
  std::memcpy(&out, from, sizeof out);
}

template <typename Vector>
inline void store(float* to, const Vector& vector) {
  std::memcpy(to, &vector, sizeof vector);
}

template <typename Vector>
inline void relu(Vector& x) {
  x = x > 0 ? x : Vector{};
}

/// a x where x < 0.
template <typename Vector>
inline void leaky_relu(Vector& x, const Vector& slope) {
  x = x > 0 ? x : x * slope;
}

inline float sum(const Native& x) {
  float out = 0;
  for (int i = 0; i < native_lanes / 2; ++i) out += x[i] + x[i + native_lanes / 2];
  return out;
}

/// The upper half of a float32, rounded to even: bfloat16.
inline std::uint16_t to_bfloat16(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return static_cast<std::uint16_t>((bits + 0x7fff + ((bits >> 16) & 1)) >> 16);
}

inline void load(Native& out, const std::uint16_t* from) {
  using Halves = std::uint16_t __attribute__((vector_size(native_lanes * sizeof(std::uint16_t))));
  using Words = std::uint32_t __attribute__((vector_size(native_lanes * sizeof(std::uint32_t))));
  Halves halves;
  std::memcpy(&halves, from, sizeof halves);
  const Words bits = __builtin_convertvector(halves, Words) << 16;
  std::memcpy(&out, &bits, sizeof out);
}

}  // namespace ertbench
