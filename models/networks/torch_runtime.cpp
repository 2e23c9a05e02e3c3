#include "models/networks/torch_runtime.h"

#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <ATen/autocast_mode.h>
#include <dlfcn.h>
#include <link.h>
#include <malloc.h>
#include <omp.h>
#include <spdlog/spdlog.h>
#include <torch/cuda.h>
#include <torch/version.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "core/errors.h"
#include "core/text.h"

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

c10::Device training_device(const std::string& name) {
  const char* const preferred = std::getenv("ERTBENCH_DEVICE");
  const std::string wanted = name == "auto" && preferred && *preferred ? preferred : name;
  const bool has_cuda = torch::cuda::is_available();
  if (wanted == "cpu" || (wanted == "auto" && !has_cuda)) return c10::kCPU;
  if (wanted != "cuda" && wanted != "auto") {
    throw InputError("ERTBENCH_DEVICE: must be auto, cpu or cuda, not " + printable(wanted));
  }
  if (!has_cuda) {
    throw InputError(std::string("device \"cuda\": ") +
                     (at::hasCUDA() ? "libtorch finds no GPU; see whether nvidia-smi does"
                                    : "this libtorch (" TORCH_VERSION ") was built without CUDA; "
                                      "build with PyTorch's (docs/solver.md)") +
                     ", or train on \"cpu\"");
  }
  at::globalContext().setAllowTF32CuDNN(false);
  at::globalContext().setBenchmarkCuDNN(true);
  return c10::kCUDA;
}

ReducedPrecision::ReducedPrecision(bool enabled, c10::Device device)
    : enabled_(enabled), device_(device) {
  if (enabled_) set(true);
}

ReducedPrecision::~ReducedPrecision() {
  if (!enabled_) return;
  at::autocast::clear_cache();  // weights that were rounded; the next step changes them
  set(false);
}

void ReducedPrecision::set(bool reduced) const {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 4)
  at::autocast::set_autocast_dtype(device_.type(), at::kBFloat16);
  at::autocast::set_autocast_enabled(device_.type(), reduced);
#else
  at::autocast::set_autocast_cpu_dtype(at::kBFloat16);
  at::autocast::set_autocast_gpu_dtype(at::kBFloat16);
  device_.is_cuda() ? at::autocast::set_enabled(reduced) : at::autocast::set_cpu_enabled(reduced);
#endif
}

}  // namespace ertbench
