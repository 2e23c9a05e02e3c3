#pragma once

#include <cstdint>
#include <cstring>

// Arrays of floats that the compiler puts into the processor's vectors: one with AVX-512, two with
// AVX2, four with plain x86-64. Functions take them by reference, as how they are passed by value
// differs between instruction sets.
namespace ertbench {

/// Channels of a map that lie side by side, and outputs of a dense layer.
constexpr int lanes = 16;

using Float16 = float __attribute__((vector_size(64)));
using Float8 = float __attribute__((vector_size(32)));

/// Vectors that a kernel can keep in registers beside what it reads.
#ifdef __AVX512F__
constexpr int register_tile = 24;
#else
constexpr int register_tile = 6;  // of sixteen registers, two to a Float16
#endif

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

inline float sum(const Float16& x) {
  Float8 low;
  Float8 high;
  std::memcpy(&low, &x, sizeof low);
  std::memcpy(&high, reinterpret_cast<const char*>(&x) + sizeof low, sizeof high);
  low += high;
  const float first = (low[0] + low[4]) + (low[1] + low[5]);
  return first + ((low[2] + low[6]) + (low[3] + low[7]));
}

/// The upper half of a float32, rounded to even: bfloat16.
inline std::uint16_t to_bfloat16(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return static_cast<std::uint16_t>((bits + 0x7fff + ((bits >> 16) & 1)) >> 16);
}

inline void load_bfloat16(Float16& out, const std::uint16_t* from) {
  using Half16 = std::uint16_t __attribute__((vector_size(32)));
  using Word16 = std::uint32_t __attribute__((vector_size(64)));
  Half16 halves;
  std::memcpy(&halves, from, sizeof halves);
  const Word16 bits = __builtin_convertvector(halves, Word16) << 16;
  std::memcpy(&out, &bits, sizeof out);
}

}  // namespace ertbench
