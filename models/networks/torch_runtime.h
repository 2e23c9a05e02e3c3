#pragma once

#include <nlohmann/json_fwd.hpp>

namespace ertbench {

/// Prepares libtorch in this process: its thread count (which its BLAS follows), denormal numbers
/// taken as zero (a saturated network trains five times slower with them), freed memory kept. Warns
/// where the reference BLAS is in use, with which dense layers are tens of times slower. Returns
/// what is in use, to be recorded:
/// `{"libtorch", "threads", "blas", "onednn", "flush_denormal"}`.
nlohmann::json start_torch(int threads);

/// For its life the calling thread's work stays on this one thread.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_;
};

/// For its life, where `enabled`, convolutions and dense layers of the calling thread compute in
/// bfloat16 (weights and sums stay float32), two to three times faster where the processor has
/// AVX512-BF16.
class ReducedPrecision {
 public:
  explicit ReducedPrecision(bool enabled);
  ~ReducedPrecision();
  ReducedPrecision(const ReducedPrecision&) = delete;
  ReducedPrecision& operator=(const ReducedPrecision&) = delete;

 private:
  bool enabled_;
};

}  // namespace ertbench
