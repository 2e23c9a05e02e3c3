#pragma once

namespace ertbench {

/// What libtorch's own libraries reach at most on one thread, FLOP/s; as in machine_limits.h
/// measured when first asked for. start_torch must have been called.

/// The better of libtorch's (OpenBLAS's) and Eigen's product of two large square matrices.
double best_gemm_float_rate();
double torch_gemm_float_rate();
/// oneDNN's 3x3 convolution in the memory layout it likes best, the best of some large shapes.
double convolution_rate();

/// Starts libtorch on one thread, notes what it runs on in the context of the benchmarks' output,
/// and shows these limits as benchmarks: "limit/gemm_float/torch", ...
void register_torch_limits();

}  // namespace ertbench
