#pragma once

#include <cstdint>
#include <functional>

namespace ertbench {

/// The arithmetic of dense layers and convolutions; all else in a network is small beside it.
/// A multiplication and an addition are two operations; what meets the padding of a convolution is
/// none.
struct Arithmetic {
  double dense_flops = 0;
  double convolution_flops = 0;
  std::int64_t dense_bytes = 0;  ///< of the matrices that dense layers multiply with
};

/// What `call` does on this thread, with the backward pass where it has one.
Arithmetic arithmetic_of(const std::function<void()>& call);

/// Least time in which one thread can do that, s, at the rates of torch_limits.h.
double least_time(const Arithmetic& work);
/// The same of a single frame: its dense layers cannot take less than the reading of their
/// matrices.
double least_time_of_one_frame(const Arithmetic& work);

/// The names of the limits that these two stand for: "gemm_float + convolution", ...
const char* limit_of(const Arithmetic& work);
const char* limit_of_one_frame(const Arithmetic& work);

}  // namespace ertbench
