#pragma once

#include <c10/core/Device.h>

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace ertbench {

/// Prepares libtorch in this process: sets the thread count (also of its BLAS), flushes denormal
/// numbers to zero (a saturated network trains five times slower with them), and keeps freed
/// memory. Warns about the reference BLAS, with which dense layers are tens of times slower.
/// Returns the configuration for the record:
/// `{"libtorch", "threads", "blas", "onednn", "flush_denormal"}`.
nlohmann::json start_torch(int threads);

/// The device of trainings that "auto", "cpu" or "cuda" stands for. "auto" is what the environment
/// variable ERTBENCH_DEVICE names, which `--device` sets, else CUDA where there is one. Float32
/// then means float32 there, too, not TF32. Throws InputError for "cuda" where there is none.
c10::Device training_device(const std::string& name);

/// Keeps the work of the calling thread on this thread while it lives.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_;
};

/// While it lives, if `enabled`, on this device convolutions and dense layers of the calling thread
/// compute in bfloat16 (weights and sums stay float32), two to three times faster with AVX512-BF16
/// or on a GPU.
class ReducedPrecision {
 public:
  explicit ReducedPrecision(bool enabled, c10::Device device = c10::kCPU);
  ~ReducedPrecision();
  ReducedPrecision(const ReducedPrecision&) = delete;
  ReducedPrecision& operator=(const ReducedPrecision&) = delete;

 private:
  void set(bool reduced) const;

  bool enabled_;
  c10::Device device_;
};

}  // namespace ertbench
