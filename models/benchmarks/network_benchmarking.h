#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "models/networks/network.h"
#include "models/solvers/learned_solver.h"
#include "models/training/objective.h"

namespace ertbench {

/// The arithmetic of dense layers and convolutions; all else in a network is small beside it.
/// A multiplication and an addition are two operations; what meets the padding of a convolution is
/// none.
struct Arithmetic {
  double dense_flops = 0;
  double convolution_flops = 0;
  std::int64_t dense_bytes = 0;  ///< of the matrices that dense layers multiply with
};

/// Operations of `call` on this thread, including a backward pass.
Arithmetic arithmetic_of(const std::function<void()>& call);

/// Least time in which one thread can do that, s, at the rates of torch_limits.h.
double least_time(const Arithmetic& work);
/// As above for a single frame, whose dense layers take at least the time to read their matrices.
double least_time_of_one_frame(const Arithmetic& work);

/// The names of the limits that these two stand for: "gemm_float + convolution", ...
const char* limit_of(const Arithmetic& work);
const char* limit_of_one_frame(const Arithmetic& work);

/// Peak rates of libtorch's own libraries on one thread, FLOP/s; as in machine_limits.h
/// measured when first asked for. start_torch must have been called.

/// The better of libtorch's (OpenBLAS's) and Eigen's product of two large square matrices.
double best_gemm_float_rate();
double torch_gemm_float_rate();
/// oneDNN's 3x3 convolution in the memory layout it likes best, the best of some large shapes.
double convolution_rate();

/// Starts libtorch on one thread, notes what it runs on in the context of the benchmarks' output,
/// and shows these limits as benchmarks: "limit/gemm_float/torch", ...
void register_torch_limits();

/// One of the learned solvers as it is timed.
struct NetworkKind {
  std::string name;
  /// The network with random weights, for the default sensor.
  std::shared_ptr<Network> (*network)();
  std::unique_ptr<Objective> (*objective)(bool bfloat16);
  /// The solver as the registry makes it, not fitted. `training` has the settings of its training.
  std::unique_ptr<Solver> (*solver)(nlohmann::json training);
};

/// fcnn, dcnn, eit-nn, dd-ert with its default of two convolutions in a block, and with the one of
/// the experiments, lean-net.
std::span<const NetworkKind> network_kinds();

}  // namespace ertbench
