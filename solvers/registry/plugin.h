#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>
#include <version>

#include "solvers/solver_info.h"

/// Compile settings that must be equal in the program and in a plugin, as one text
/// `name=value;name=value;...` that the compiler puts together where this header is included.
/// Vectors of Eigen's are aligned, passed and freed by the alignment and the instruction set,
/// classes of the library by the compiler and its switches: where they differ, memory is corrupted
/// without a word.

/// Raised with every change of what plugins see (solvers/solver.h, solver_info.h, registry.h).
#define ERTBENCH_SOLVER_INTERFACE 9

#define ERTBENCH_ABI_TEXT_OF(x) #x
#define ERTBENCH_ABI_TEXT(x) ERTBENCH_ABI_TEXT_OF(x)

#if defined(__clang__)
#define ERTBENCH_ABI_COMPILER "clang " ERTBENCH_ABI_TEXT(__clang_major__)
#else
#define ERTBENCH_ABI_COMPILER "gcc " ERTBENCH_ABI_TEXT(__GNUC__)
#endif

#ifdef _GLIBCXX_DEBUG
#define ERTBENCH_ABI_DEBUG " debug"
#else
#define ERTBENCH_ABI_DEBUG ""
#endif

#if defined(_GLIBCXX_RELEASE)
#define ERTBENCH_ABI_LIBRARY \
  "libstdc++ abi " ERTBENCH_ABI_TEXT(_GLIBCXX_USE_CXX11_ABI) ERTBENCH_ABI_DEBUG
#else
#define ERTBENCH_ABI_LIBRARY "another"
#endif

// The part of the instruction set that changes how vectors are passed and which of Eigen's kernels
// both sides have under one name.
#ifdef __SSE4_2__
#define ERTBENCH_ABI_SSE " sse4.2"
#else
#define ERTBENCH_ABI_SSE ""
#endif
#ifdef __AVX__
#define ERTBENCH_ABI_AVX " avx"
#else
#define ERTBENCH_ABI_AVX ""
#endif
#ifdef __AVX2__
#define ERTBENCH_ABI_AVX2 " avx2"
#else
#define ERTBENCH_ABI_AVX2 ""
#endif
#ifdef __FMA__
#define ERTBENCH_ABI_FMA " fma"
#else
#define ERTBENCH_ABI_FMA ""
#endif
#ifdef __AVX512F__
#define ERTBENCH_ABI_AVX512 " avx512f"
#else
#define ERTBENCH_ABI_AVX512 ""
#endif
#ifdef __AVX512DQ__
#define ERTBENCH_ABI_AVX512DQ " avx512dq"
#else
#define ERTBENCH_ABI_AVX512DQ ""
#endif

#ifdef __SANITIZE_ADDRESS__
#define ERTBENCH_ABI_SANITIZER "address"
#else
#define ERTBENCH_ABI_SANITIZER "none"
#endif

/// Found in a library's file by this beginning, before the library is loaded.
#define ERTBENCH_PLUGIN_ABI_MARK "ertbench-plugin-abi:"

#define ERTBENCH_PLUGIN_ABI \
  ERTBENCH_PLUGIN_ABI_MARK  \
  "solver interface=" ERTBENCH_ABI_TEXT(ERTBENCH_SOLVER_INTERFACE) ";"                            \
  "compiler=" ERTBENCH_ABI_COMPILER ";"                                                           \
  "C++ library=" ERTBENCH_ABI_LIBRARY ";"                                                         \
  "Eigen=" ERTBENCH_ABI_TEXT(EIGEN_WORLD_VERSION) "." ERTBENCH_ABI_TEXT(EIGEN_MAJOR_VERSION) "."  \
      ERTBENCH_ABI_TEXT(EIGEN_MINOR_VERSION) ";"                                                  \
  "Eigen's alignment=" ERTBENCH_ABI_TEXT(EIGEN_MAX_ALIGN_BYTES) " bytes, on the stack "           \
      ERTBENCH_ABI_TEXT(EIGEN_MAX_STATIC_ALIGN_BYTES) ";"                                         \
  "instruction set=sse2" ERTBENCH_ABI_SSE ERTBENCH_ABI_AVX ERTBENCH_ABI_AVX2 ERTBENCH_ABI_FMA     \
      ERTBENCH_ABI_AVX512 ERTBENCH_ABI_AVX512DQ ";"                                               \
  "address sanitizer=" ERTBENCH_ABI_SANITIZER ";"

namespace ertbench {

/// The settings of this program.
std::string program_abi();

/// In what a plugin's text differs from this program's: "compiler gcc 11, here gcc 12; ...". Empty
/// where they are the same.
std::string abi_difference(const std::string& plugin);

/// Description that a shared library of solvers gives of itself. All of it without
/// SolverInfo::make: the solvers themselves are in another process, and made where the library is
/// loaded.
struct PluginDescription {
  std::vector<SolverType> types;
  /// Where the library is refused in an orderly way: the message of the InputError.
  std::string refused;
  /// Where it took its process down, threw anything else or did not come back: how.
  std::string failed;
};

/// Has `load` load a library in a process of its own, which passes on what types it brought.
PluginDescription describe_in_child(const std::function<std::vector<SolverType>()>& load);

/// Seconds that loading a library may take, and after that making one solver of it.
inline constexpr double plugin_time_limit_s = 60;

class SolverRegistry;

/// Folders in which plugins are looked for: that of the running program, that of the learned
/// solvers where it is installed, then those of $ERTBENCH_PLUGINS, separated by ':'.
std::vector<std::filesystem::path> plugin_folders();

/// Opens a shared library of solvers, checks the interface it was built against and lets it
/// register its solvers. It stays open until the program ends. Throws InputError.
void register_plugin(const std::filesystem::path& library, SolverRegistry& registry);

}  // namespace ertbench
