#include "models/networks/torch_runtime.h"

#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <ATen/autocast_mode.h>
#include <dlfcn.h>
#include <link.h>
#include <malloc.h>
#include <omp.h>
#include <spdlog/spdlog.h>
#include <torch/version.h>

#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

namespace ertbench {
namespace {

/// Keeps freed memory: a training step frees and asks for the same large tensors again, and handing
/// them back to the system each time costs up to half of the step in page faults.
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most it takes
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

/// The file from which this process has its BLAS.
std::string blas_library() {
  std::string found;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* out) {
        const std::string path = info->dlpi_name;
        if (path.find("blas") == std::string::npos && path.find("libmkl") == std::string::npos) {
          return 0;
        }
        *static_cast<std::string*>(out) = path;
        return 1;
      },
      &found);
  return found;
}

/// How the BLAS calls itself.
std::string blas_name() {
  const std::string path = blas_library();
  if (path.empty()) return "none";
  if (void* const library = dlopen(path.c_str(), RTLD_LAZY | RTLD_NOLOAD)) {
    using Text = char* (*)();
    const auto version = reinterpret_cast<Text>(dlsym(library, "openblas_get_config"));
    const auto kernels = reinterpret_cast<Text>(dlsym(library, "openblas_get_corename"));
    if (version && kernels) return std::string(version()) + ", kernels for " + kernels();
  }
  if (path.find("mkl") != std::string::npos) return "MKL";
  spdlog::warn(
      "libtorch uses the reference BLAS {}, which makes dense layers tens of times slower; "
      "apt-get install libopenblas0-openmp",
      path);
  return "reference, " + path;
}

}  // namespace

nlohmann::json start_torch(int threads) {
  static const std::string blas = [] {
    keep_freed_memory();
    return blas_name();
  }();
  // Before the first parallel work: OpenMP's threads inherit the setting.
  const bool flush = at::globalContext().setFlushDenormal(true);
  at::set_num_threads(threads);
  return {{"libtorch", TORCH_VERSION},
          {"threads", at::get_num_threads()},
          {"blas", blas},
          {"onednn", at::globalContext().hasMKLDNN()},
          {"flush_denormal", flush}};
}

OneThread::OneThread() : before_(omp_get_max_threads()) {
  if (before_ != 1) omp_set_num_threads(1);
}

OneThread::~OneThread() {
  if (before_ != 1) omp_set_num_threads(before_);
}

ReducedPrecision::ReducedPrecision(bool enabled) : enabled_(enabled) {
  if (!enabled_) return;
  at::autocast::set_autocast_cpu_dtype(at::kBFloat16);
  at::autocast::set_cpu_enabled(true);
}

ReducedPrecision::~ReducedPrecision() {
  if (!enabled_) return;
  at::autocast::clear_cache();  // weights that were rounded; the next step changes them
  at::autocast::set_cpu_enabled(false);
}

}  // namespace ertbench
