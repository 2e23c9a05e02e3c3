#pragma once

#include <nlohmann/json_fwd.hpp>

namespace ertbench {

/// Prepares libtorch in this process: sets the thread count (also of its BLAS), flushes denormal
/// numbers to zero (a saturated network trains five times slower with them), and keeps freed
/// memory. Warns about the reference BLAS, with which dense layers are tens of times slower.
/// Returns the configuration for the record:
/// `{"libtorch", "threads", "blas", "onednn", "flush_denormal"}`.
nlohmann::json start_torch(int threads);

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

/// While it lives, if `enabled`, convolutions and dense layers of the calling thread compute in
/// bfloat16 (weights and sums stay float32), two to three times faster with AVX512-BF16.
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
